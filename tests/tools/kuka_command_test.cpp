#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string_view>
#include <utility>

#include "config/text_file.hpp"
#include "proto/rsi/context.hpp"
#include "tests/process.hpp"
#include "tests/rsi_flaws.hpp"
#include "tests/temp_folder.hpp"

namespace truepose {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

/// The example cell on the network of a real one, and what `truepose kuka write` makes of it.
struct KukaCommand : testing::Test {
  KukaCommand() {
    change(R"(listen: 127.0.0.1:49152)", "listen: 192.168.44.77:49200");
    change("eki_motion: 127.0.0.1:54600", "eki_motion: 10.1.2.3:54610");
    change("file: robots/", "file: " TRUEPOSE_SOURCE_DIR "/config/robots/");
    change("ethernet_xml: kuka/", "ethernet_xml: " + (set_ / "SensorInterface").string() + "/../");
  }
  void change(const std::string& from, const std::string& to) {
    const std::size_t at = text_.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text_.replace(at, from.size(), to);
  }
  std::string cell() { return folder_.write("cell.yaml", text_); }
  Finished write(const std::string& kss = "8.6") {
    return run_program("truepose", {"kuka", "write", "--cell", cell(), "--kss", kss, "--out", set_.string()});
  }
  Finished lint(const std::vector<std::string>& files) {
    std::vector<std::string> arguments{"kuka", "lint", "--cell", cell()};
    for (const std::string& file : files) arguments.push_back((set_ / "SensorInterface" / file).string());
    return run_program("truepose", arguments);
  }
  std::string written(const std::string& file) { return text_of(set_ / file); }

  TempFolder folder_;
  std::filesystem::path set_ = folder_.path() / "set";
  std::string text_ = config::read_text_file(TRUEPOSE_SOURCE_DIR "/config/cell.yaml");
};

TEST_F(KukaCommand, WritesTheControllersFilesWithTheCellsAddressesAndLimits) {
  change("max_total_deg: 3 ", "max_total_deg: 2 ");
  const Finished done = write();
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_THAT(done.out, AllOf(HasSubstr("TP_SUBMIT_CYCLE() in the fold USER PLC"),
                              HasSubstr("Not run on hardware yet")));
  const auto ethernet = rsi::parse_ethernet_config(written("SensorInterface/truepose_rsi_ethernet.xml"));
  ASSERT_TRUE(ethernet) << ethernet.error();
  EXPECT_EQ(ethernet->address, "192.168.44.77");
  EXPECT_EQ(ethernet->port, 49200);
  const auto context = rsi::parse_context(written("SensorInterface/truepose_rsi.rsix"));
  ASSERT_TRUE(context) << context.error();
  EXPECT_EQ(context->of_type("AXISCORR")->number("UpperLimA6"), 2);
  EXPECT_EQ(context->of_type("AXISCORRMON")->number("MaxA1"), 3);
  EXPECT_THAT(written("EthernetKRL/CellLink.xml"),
              AllOf(HasSubstr("<IP>10.1.2.3</IP>"), HasSubstr("<PORT>54610</PORT>")));
  EXPECT_THAT(written("EthernetKRL/CellState.xml"), HasSubstr("<PORT>54601</PORT>"));
  EXPECT_EQ(written("Program/truepose_motion.src"),
            config::read_text_file(TRUEPOSE_SOURCE_DIR "/config/kuka/krl/truepose_motion.src"));
}

TEST_F(KukaCommand, WritesTheContextAsTheVersionOfRsiHasIt) {
  const std::map<std::string, std::pair<std::string, std::string>> kept_as{
      {"8.3", {"truepose_rsi.rsi.xml", "<RSIObjects"}},
      {"8.4", {"truepose_rsi.rsi.xml", "<RSIObjects"}},
      {"8.5", {"truepose_rsi.rsix", "Version=\"0.1.0\""}},
      {"8.6", {"truepose_rsi.rsix", "SchemaVersion=\"2.0.0\""}},
      {"8.7", {"truepose_rsi.rsix", "SchemaVersion=\"2.0.0\""}}};
  for (const auto& [kss, context] : kept_as) {
    SCOPED_TRACE(kss);
    std::filesystem::remove_all(set_);
    ASSERT_EQ(write(kss).exit_code, 0);
    EXPECT_THAT(written("SensorInterface/" + context.first), HasSubstr(context.second));
    const Finished judged = lint({"truepose_rsi_ethernet.xml", context.first});
    EXPECT_EQ(judged.exit_code, 0) << judged.out << judged.err;
    const bool with_extension = context.first.ends_with(".rsi.xml");
    for (const char* program : {"Program/truepose_motion.src", "Program/truepose_stream.src"}) {
      EXPECT_THAT(written(program), HasSubstr(with_extension ? "RSI_CREATE(\"truepose_rsi.rsi\","
                                                             : "RSI_CREATE(\"truepose_rsi\","));
    }
  }
  EXPECT_EQ(write("8.2").exit_code, 2);
}

TEST_F(KukaCommand, StartsRsiInTheCycleOfTheCellAndLetsNoProductionProgramRunAt12Ms) {
  ASSERT_EQ(write().exit_code, 0);
  EXPECT_THAT(written("Program/truepose_stream.dat"), HasSubstr("TP_CORRECTS_PTP=TRUE"));
  change("cycle_ms: 4 ", "cycle_ms: 12 ");
  const Finished done = write();
  ASSERT_EQ(done.exit_code, 0);
  EXPECT_THAT(done.out, HasSubstr("TP_BEGIN() refuses"));
  EXPECT_THAT(written("Program/truepose_motion.src"), AllOf(HasSubstr("#IPO)"), Not(HasSubstr("#IPO_FAST"))));
  EXPECT_THAT(written("Program/truepose_stream.dat"), HasSubstr("TP_CORRECTS_PTP=FALSE"));
}

TEST_F(KukaCommand, LetsAProgramWaitLongerThanRsiDoes) {
  change("timeout_cycles: 100 ", "timeout_cycles: 500 ");
  ASSERT_EQ(write().exit_code, 0);
  EXPECT_THAT(written("Program/truepose_stream.dat"), HasSubstr("TP_PATIENCE=251"));  // 3 s of 2
}

TEST_F(KukaCommand, RefusesAnAddressThatNoControllerCouldSendTo) {
  std::string before = "192.168.44.77:49200";
  for (const char* address : {"127.0.0.1:49200", "0.0.0.0:49200"}) {
    change(before, address);
    before = address;
    const Finished done = write();
    EXPECT_EQ(done.exit_code, 2);
    EXPECT_THAT(done.err, AllOf(HasSubstr("stream.listen"), HasSubstr("RSI network")));
    EXPECT_FALSE(std::filesystem::exists(set_));
  }
}

TEST_F(KukaCommand, SaysThatAFolderCannotBeWrittenTo) {
  folder_.write("set", "a file");
  const Finished done = write();
  EXPECT_EQ(done.exit_code, 2);
  EXPECT_THAT(done.err, HasSubstr("set/EthernetKRL/CellLink.xml"));
}

TEST_F(KukaCommand, FindsNothingInWhatItWritesAndEveryFlawInWhatIsChanged) {
  ASSERT_EQ(write().exit_code, 0);
  const Finished good = lint({"truepose_rsi_ethernet.xml", "truepose_rsi.rsix"});
  EXPECT_EQ(good.exit_code, 0) << good.out << good.err;
  EXPECT_THAT(good.out,
              AllOf(HasSubstr("truepose_rsi.rsix: good"), HasSubstr("truepose_rsi_ethernet.xml: good")));

  change("max_total_deg: 3 ", "max_total_deg: 9 ");
  change("192.168.44.77", "192.168.44.78");
  const Finished bad = lint({"truepose_rsi.rsix", "truepose_rsi_ethernet.xml"});
  EXPECT_EQ(bad.exit_code, 1);
  EXPECT_THAT(
      bad.out,
      AllOf(HasSubstr("truepose_rsi_ethernet.xml: the controller sends to 192.168.44.77:49200 (IP_NUMBER "
                      "and PORT), but stream.listen is 192.168.44.78:49200. Make them the same.\n"),
            HasSubstr("truepose_rsi.rsix: AXISCORR1: A1 is clamped silently to -3 .. 3 deg "
                      "(stream.max_total_deg: 9 deg). Widen LowerLim and UpperLim of the axes, or lower "
                      "stream.max_total_deg.\n"),
            HasSubstr("AXISCORR1: A3 is clamped silently to -3 .. 3 deg (stream.max_total_deg: 9 deg).\n"),
            HasSubstr("AXISCORRMON1: RSI stops at 4 deg of A3 (stream.max_total_deg: 9 deg).\n")));

  const Finished damaged = run_program("truepose", {"kuka", "lint", cell()});
  EXPECT_EQ(damaged.exit_code, 2);
  EXPECT_THAT(damaged.err, HasSubstr("cell.yaml: not an XML document"));
  const Finished alone =
      run_program("truepose", {"kuka", "lint", (set_ / "SensorInterface/truepose_rsi.rsix").string()});
  EXPECT_EQ(alone.exit_code, 2);
  EXPECT_THAT(alone.err, HasSubstr("give the RSI ethernet configuration too"));
}

/// Of what a format of fmt makes, with any values.
std::string pattern_of(std::string_view format) {
  std::string pattern;
  for (std::size_t i = 0; i < format.size(); ++i) {
    if (format[i] == '{') {
      pattern += "[^\n]*";
      i = format.find('}', i);
    } else {
      if (std::string_view{"\\.^$|()[*+?"}.contains(format[i])) pattern += '\\';
      pattern += format[i];
    }
  }
  return pattern;
}

TEST_F(KukaCommand, LintFindsEachKindOfFlawInAnExampleAndSaysWhatToDo) {
  ASSERT_EQ(write().exit_code, 0);
  const std::filesystem::path files = set_ / "SensorInterface";
  const std::string ethernet = text_of(files / "truepose_rsi_ethernet.xml");
  std::map<rsi::LintKind, std::string> said;
  const auto judge = [&](rsi::LintKind kind) {
    const Finished judged = lint({"truepose_rsi_ethernet.xml", "truepose_rsi.rsix"});
    EXPECT_EQ(judged.exit_code, 1) << judged.out << judged.err;
    said[kind] += judged.out;
  };
  for (const rsi::EthernetFlaw& flaw : rsi::ethernet_flaws()) {
    std::string text = ethernet;
    config::write_text_file(files / "truepose_rsi_ethernet.xml",
                            text.replace(text.find(flaw.from), flaw.from.size(), flaw.to));
    judge(flaw.kind);
  }
  config::write_text_file(files / "truepose_rsi_ethernet.xml", ethernet);
  for (const rsi::ContextFlaw& flaw : rsi::context_flaws()) {
    rsi::Context context = rsi::truepose_context({});
    flaw.make(context);
    config::write_text_file(files / "truepose_rsi.rsix", context_xml(context, rsi::ContextFormat::Rsix));
    judge(flaw.kind);
  }
  change("192.168.44.77", "192.168.44.78");
  judge(rsi::LintKind::Address);

  for (std::size_t i = 0; i < rsi::kLintKinds.size(); ++i) {
    const MessageKind& kind = rsi::kLintKinds[i];
    EXPECT_THAT(said[static_cast<rsi::LintKind>(i)],
                ContainsRegex(pattern_of(kind.what) + "\\. " +
                              pattern_of(with_capital(std::string{kind.what_to_do})) + "\\."))
        << kind.code;
  }
}

}  // namespace
}  // namespace truepose
