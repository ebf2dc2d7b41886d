// Another reader of the same facts: objects.tsv taken apart line by line, and XML by its own paths.
#include <gmock/gmock.h>

#include <filesystem>
#include <map>
#include <pugixml.hpp>
#include <sstream>

#include "config/text_file.hpp"
#include "proto/rsi/context.hpp"

namespace truepose::rsi {
namespace {

using testing::HasSubstr;

/// The lines of a table of objects, by number and name of the object.
std::map<std::string, std::string> lines_of(const std::string& text) {
  std::map<std::string, std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line.starts_with('#')) continue;
    lines[line.substr(0, line.find('\t', line.find('\t') + 1))] += line + "\n";
  }
  return lines;
}

const std::string kTable =
    config::read_text_file(std::string{TRUEPOSE_SOURCE_DIR} + "/proto/rsi/objects.tsv");

TEST(ObjectCatalogue, HasEveryObjectOfTheTable) {
  std::size_t later = 0;
  for (const auto& [key, lines] : lines_of(kTable))
    later += lines.contains("\t5.0\t") || lines.contains("\t6.2\t");
  EXPECT_EQ(lines_of(kTable).size(), later);
  EXPECT_EQ(object_catalogue(ContextFormat::Rsix6).size(), lines_of(kTable).size());
  EXPECT_EQ(catalogued("ov_pro")->name, "OV_PRO");
  EXPECT_EQ(catalogued("OV_PRO")->id, 63);
  EXPECT_EQ(number_of("STATUS", "Type", "Mode_Op"), 5);
  EXPECT_EQ(number_of("STATUS", "Type", "ProState_R"), 2);
  EXPECT_EQ(number_of("STATUS", "Type", "None"), -1);
  EXPECT_EQ(number_of("STOP", "Mode", "ExitMoveCorr"), 4);
  EXPECT_EQ(otherwise("POSCORR", "RefCorrSys"), 1);
  EXPECT_EQ(otherwise("AXISCORR", "LowerLimA1"), -5);
  EXPECT_EQ(otherwise("AXISCORRMON", "MaxA6"), 6);
  EXPECT_EQ(otherwise("ETHERNET", "Timeout"), 10);
  EXPECT_EQ(catalogued("MESSAGE"), nullptr);
  EXPECT_NE(catalogued("MESSAGE", ContextFormat::Rsix6), nullptr);
  EXPECT_FALSE(catalogued("AXISCORRMON")->parameter("MaxA1")->fixed);
  EXPECT_TRUE(catalogued("AXISCORRMON", ContextFormat::Rsix6)->parameter("MaxA1")->fixed);
  EXPECT_EQ(catalogued("AXISCORREXT", ContextFormat::RsiXml)->id, 33);
}

/// What an attribute of the file says must stand in the object's line of the table.
void expect_in_table(const pugi::xml_node& object, const std::string& lines) {
  for (const pugi::xml_node& parameter : object.child("Parameters").children("Parameter")) {
    const std::string named =
        std::string{parameter.attribute("ParamId").value()} + ":" + parameter.attribute("Name").value() + ":";
    EXPECT_THAT(lines, HasSubstr(named)) << object.attribute("ObjId").value();
  }
  for (const pugi::xml_node& input : object.child("Inputs").children("Input")) {
    const std::string at = std::string{input.attribute("InIdx").value()} + ":";
    if (lines.contains('*')) continue;  // as many inputs as are wired
    EXPECT_THAT(lines, HasSubstr(at)) << object.attribute("ObjId").value();
  }
}

TEST(ObjectCatalogue, HoldsEveryObjectOfEveryContextThatIsWritten) {
  const auto lines = lines_of(kTable);
  for (const ContextFormat format : {ContextFormat::Rsix40, ContextFormat::Rsix, ContextFormat::Rsix6}) {
    pugi::xml_document document;
    ASSERT_TRUE(document.load_string(context_xml(truepose_context({}), format).c_str()));
    int objects = 0;
    for (const auto& found : document.select_nodes("//RsiObject")) {
      const std::string key = std::string{found.node().attribute("ObjTypeId").value()} + "\t" +
                              found.node().attribute("ObjType").value();
      ASSERT_TRUE(lines.contains(key)) << key;
      expect_in_table(found.node(), lines.at(key));
      ++objects;
    }
    EXPECT_EQ(objects, 10);
  }
}

/// "0:Mode:Enum=ExitMoveCorr{0:InfoMessage 1:..}" of the handed table, as ours has it.
TEST(ObjectCatalogue, AgreesWithTheHandedTable) {
  const auto handed = std::filesystem::path{TRUEPOSE_SOURCE_DIR} / "../shared/facts/rsi-objects.tsv";
  if (!std::filesystem::exists(handed)) GTEST_SKIP() << "needs ../shared/facts/rsi-objects.tsv";
  const auto lines = lines_of(config::read_text_file(handed));
  EXPECT_EQ(lines.size(), object_catalogue(ContextFormat::Rsix6).size());
  for (const CatalogueObject& object : object_catalogue(ContextFormat::Rsix6)) {
    const std::string key = std::to_string(object.id) + "\t" + object.name;
    ASSERT_TRUE(lines.contains(key)) << key;
    for (const CatalogueParameter& parameter : object.parameters) {
      EXPECT_THAT(lines.at(key), HasSubstr(std::to_string(parameter.ordinal) + ":" + parameter.name + ":"));
      for (std::size_t k = 0; k < parameter.values.size(); ++k)
        EXPECT_THAT(lines.at(key), HasSubstr(std::to_string(k) + ":" + parameter.values[k]))
            << parameter.name;
    }
    for (const auto* ports : {&object.inputs, &object.outputs}) {
      for (std::size_t k = 0; k < ports->size(); ++k)
        EXPECT_THAT(lines.at(key), HasSubstr(std::to_string(k) + ":" + (*ports)[k].name)) << key;
    }
  }
}

}  // namespace
}  // namespace truepose::rsi
