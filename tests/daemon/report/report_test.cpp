#include "daemon/report/report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <cstdlib>
#include <map>
#include <pugixml.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/daemon/page.hpp"
#include "tests/daemon/sample_document.hpp"

namespace truepose::report {
namespace {

namespace json = boost::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using Rows = std::map<std::string, std::vector<std::string>>;

/// The cells of a table's rows by "GROUP/ROW", where the group is the first word of the heading row above.
Rows rows_of(const pugi::xml_document& page, const char* table_class) {
  Rows rows;
  std::string group;
  const std::string path = std::string("//table[@class='") + table_class + "']/tbody/tr";
  for (const pugi::xpath_node& row : page.select_nodes(path.c_str())) {
    const pugi::xml_node head = row.node().child("th");
    if (std::string(head.attribute("class").value()) == "rows") {
      group = text_of(head).substr(0, text_of(head).find(':'));
      continue;
    }
    std::vector<std::string>& cells = rows[group + "/" + text_of(head)];
    for (const pugi::xml_node& cell : row.node().children("td")) cells.push_back(text_of(cell));
  }
  return rows;
}

std::vector<std::string> headings(const pugi::xml_document& page) {
  std::vector<std::string> result;
  for (const pugi::xpath_node& node : page.select_nodes("//h2")) result.push_back(text_of(node.node()));
  return result;
}

void expect_statistics(const std::vector<std::string>& cells, const json::object& s) {
  std::vector<double> expected;
  for (const char* key : {"mean", "max", "min", "rms", "std"})
    expected.push_back(s.at(key).to_number<double>());
  for (const char* axis : {"x", "y", "z"}) {
    for (const char* key : {"mean_abs", "max"}) {
      expected.push_back(s.at(axis).as_object().at(key).to_number<double>());
    }
  }
  ASSERT_EQ(cells.size(), expected.size() + 1);  // and the factor
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(std::strtod(cells[i].c_str(), nullptr), expected[i], 0.000501) << "column " << i;
  }
}

TEST(Report, IsWellFormedWithAndWithoutTheOptionalParts) {
  for (const json::object& document :
       {sample_document(30, false), sample_document(30, true), full_document(30), full_document(2)}) {
    const pugi::xml_document page = parsed(render_html(document));
    EXPECT_EQ(page.select_nodes("//script").size(), 1u);
    EXPECT_FALSE(page.select_node("//script[@src]|//link|//img"));  // nothing to fetch
  }
}

TEST(Report, ShowsEveryFigureOfTheStatisticsAsItIsInTheDocument) {
  const json::object document = full_document(30);
  const Rows rows = rows_of(parsed(render_html(document)), "statistics");
  ASSERT_EQ(rows.size(), 7u);
  for (const auto& [set, title] : {std::pair{"identify", "Identification"}, {"validate", "Validation"}}) {
    for (const auto& [stage, row] :
         {std::pair{"before", "Before"}, {"geometric", "Geometric"}, {"after", "All layers"}}) {
      SCOPED_TRACE(std::string(title) + "/" + row);
      expect_statistics(rows.at(std::string(title) + "/" + row), document.at(set).at(stage).as_object());
    }
  }
  expect_statistics(rows.at("Validation/Compensated"), document.at("remeasured").as_object());
}

TEST(Report, StartsWithTheMeanErrorBeforeAndAfterAndTheirRatio) {
  json::object document = full_document(30);
  document["validate"].as_object()["before"].as_object()["mean"] = 2.862;
  document["remeasured"].as_object()["mean"] = 0.571;
  const pugi::xml_document page = parsed(render_html(document));
  EXPECT_EQ(text_of(page.select_node("//p[@class='headline']").node()),
            "2.862 mm→0.571 mm5.0 times more accurate");
}

TEST(Report, WarnsOfAModelThatIsWorseNotConvergedOrNotValidated) {
  json::object document = sample_document(30, false);
  document["converged"] = false;
  document["identify"].as_object()["before"].as_object()["mean"] = 0.1;
  const std::string html = render_html(document);
  EXPECT_THAT(html, HasSubstr("no improvement"));
  EXPECT_THAT(html, HasSubstr("Not converged"));
  EXPECT_THAT(html, HasSubstr("Not validated"));
}

TEST(Report, HasNoHeadingOverNothing) {
  EXPECT_THAT(headings(parsed(render_html(full_document(30)))),
              ElementsAre("Position error before and after", "Conditions", "How the errors are spread",
                          "Where the errors are", "Validation points", "Identification points",
                          "Residuals, joint by joint", "Identified parameters",
                          "Not identifiable from the data", "Stream of corrections", "Raw data"));
  json::object bare = sample_document(30, false);
  bare.erase("points");
  const std::string html = render_html(bare);
  EXPECT_THAT(headings(parsed(html)),
              ElementsAre("Position error before and after", "Conditions", "Identified parameters",
                          "Not identifiable from the data", "Raw data"));
  EXPECT_THAT(html, Not(HasSubstr("Compensated")));
  EXPECT_THAT(html, Not(HasSubstr("true value")));
}

TEST(Report, PutsTheTruthNextToTheIdentifiedValues) {
  const Rows rows = rows_of(parsed(render_html(full_document(30))), "parameters");
  // unit, nominal, value, deviation, sigma, status, truth, difference
  EXPECT_THAT(rows.at("Link 2/a"),
              ElementsAre("mm", "330.000", "330.626", "0.626", "0.011", "identified", "330.630", "-0.004"));
  EXPECT_THAT(rows.at("Link 2/β"), ElementsAre("deg", "0.0000", "0.0000", "0.0000", "", "kept, by convention",
                                               "0.0573", "-0.0573"));
  EXPECT_THAT(rows.at("Reflector 1 in the flange frame/x"),
              ElementsAre("mm", "", "40.100", "", "0.0080", "identified", "40.000", "0.100"));
  // A turn of 360 degrees is no difference.
  EXPECT_EQ(rows.at("Base of the robot in the tracker's frame/rz").back(), "0.0000");
}

TEST(Report, EscapesHostileTexts) {
  const std::string hostile = "</script><script>alert('1')</script>\"&\x01";
  json::object document = full_document(6);
  for (const char* key : {"robot", "tracker", "campaign", "model", "date"}) document[key] = hostile;
  document["files"] = document["options"] = json::object{{hostile, hostile}};
  document["skipped"] = json::array(1, {{"pose", 3}, {"attempts", 2}, {"reason", hostile}});
  document["arm"].as_object()["name"] = hostile;
  for (json::value& point : document["points"].as_array()) point.as_object()["smr"] = hostile;
  document["parameters"].as_array()[2].as_object()["name"] = "smr." + hostile + ".x";
  const std::string html = render_html(document);
  EXPECT_THAT(html, Not(HasSubstr("<script>alert")));
  const pugi::xml_document page = parsed(html);
  EXPECT_EQ(text_of(page.select_node("//h1").node()), "</script><script>alert('1')</script>\"&\uFFFD");
}

TEST(Report, NamesTheMemberThatIsMissingOrOfTheWrongKind) {
  json::object document = full_document(6);
  document["validate"].as_object()["before"].as_object()["x"].as_object().erase("rms");
  EXPECT_THAT([&] { render_html(document); }, testing::ThrowsMessage<std::invalid_argument>(
                                                  HasSubstr("validate.before.x: missing key 'rms'")));
  document = full_document(6);
  document["points"].as_array()[3].as_object()["after"] = {1, 2};
  EXPECT_THAT([&] { render_html(document); }, testing::ThrowsMessage<std::invalid_argument>(
                                                  HasSubstr("points[3].after: expected 3 numbers, found 2")));
}

TEST(ReportText, SaysWhatNotToTrust) {
  json::object document = sample_document(30, false);
  document["converged"] = false;
  document["verdict"] = {{"color", "red"},
                         {"findings",
                          {{{"severity", "error"},
                            {"code", "V_NOT_CONVERGED"},
                            {"sentence", "the identification did not converge"},
                            {"what_to_do", "check the robot file"}},
                           {{"severity", "warning"},
                            {"code", "V_NOT_VALIDATED"},
                            {"sentence", "nothing but the points that it was fitted to shows how good it is"},
                            {"what_to_do", "check the robot file"}}}}};
  const std::string text = render_text(document);
  EXPECT_THAT(text, Not(HasSubstr("Validation")));
  EXPECT_THAT(text, HasSubstr("did not converge"));
  EXPECT_THAT(text, HasSubstr("\nVerdict: red. Do not use this model.\n  error: the identification did not "
                              "converge. Check the robot file.\n"));
  EXPECT_THAT(text,
              HasSubstr("\n  warning: nothing but the points that it was fitted to shows how good it is.\n"))
      << "the same thing to do is said once";
}

}  // namespace
}  // namespace truepose::report
