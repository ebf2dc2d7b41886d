// The sections of the page on the measurement itself, and what the page carries.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <pugixml.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/report/report.hpp"
#include "daemon/report/sections.hpp"
#include "proto/record/frame_document.hpp"
#include "tests/daemon/page.hpp"
#include "tests/daemon/sample_document.hpp"

namespace truepose::report {
namespace {

namespace json = boost::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

json::value conditions() {
  return json::parse(R"({"started": "2026-05-04T07:00:12.000Z", "ended": "2026-05-04T07:31:00.000Z",
      "poses_measured": 88, "poses_skipped": 2, "temperature_c": {"min": 20.04, "max": 21.3},
      "pressure_mbar": {"min": 1013, "max": 1013}, "humidity_percent": {"min": 45, "max": 47}})");
}

/// The rows of the conditions by their names.
std::vector<std::string> fact(const std::string& html, const std::string& name) {
  std::vector<std::string> values;
  const pugi::xml_document page = parsed(html);
  for (const pugi::xpath_node& row : page.select_nodes("//div[@class='facts']//tr")) {
    if (text_of(row.node().child("th")) == name) values.push_back(text_of(row.node().child("td")));
  }
  return values;
}

TEST(ReportConditions, TellUnderWhichAirAndWhenItWasMeasuredAndWhichPosesWereSkipped) {
  json::object document = full_document(6);
  document["conditions"] = conditions();
  document["skipped"] = json::parse(R"([{"pose": 12, "attempts": 3, "reason": "no reflector found"}])");
  document["date"] = "2026-05-04T07:31:00.000Z";
  document["model"] = "0123456789abcdef";
  const std::string html = render_html(document);
  EXPECT_THAT(fact(html, "Time"), ElementsAre("2026-05-04 07:00 UTC to 2026-05-04 07:31 UTC"));
  EXPECT_THAT(fact(html, "Poses"), ElementsAre("88 measured, 2 skipped"));
  EXPECT_THAT(fact(html, "Air temperature"), ElementsAre("20.0 to 21.3 °C"));
  EXPECT_THAT(fact(html, "Air pressure"), ElementsAre("1013.0 mbar"));
  EXPECT_THAT(fact(html, "Pose 12, after 3 attempts"), ElementsAre("no reflector found"));
  EXPECT_EQ(text_of(parsed(html).select_node("//p[@class='identity']").node()),
            "Leica AT960 · Campaign 12 · Model 01234567 · 2026-05-04 07:31 UTC");
}

TEST(ReportConditions, HaveNoRowForWhatIsNotKnown) {
  json::object document = sample_document(6, true);
  document.erase("arm");
  const std::string html = render_html(document);
  const pugi::xml_document page = parsed(html);
  for (const pugi::xpath_node& cell : page.select_nodes("//div[@class='facts']//td")) {
    EXPECT_NE(text_of(cell.node()), "");
  }
  EXPECT_THAT(fact(html, "Time"), ElementsAre());
  EXPECT_THAT(html, Not(HasSubstr("<h3>Arm</h3>")));
}

TEST(ReportConditions, SayHowFarTheReferencePoseDrifted) {
  json::object document = sample_document(6, true);
  document["reference_drift_mm"] = {0.0, 0.012, 0.031, 0.025};
  const std::string html = render_html(document);
  EXPECT_THAT(html, HasSubstr("0.031 mm at most, 0.025 mm at the end"));
  EXPECT_EQ(parsed(html).select_nodes("//h2[.='Drift while it was measured']/..//circle[title]").size(), 4U);
  document["reference_drift_mm"] = json::array{0.0};
  EXPECT_THAT(render_html(document), Not(HasSubstr("Drift while")));
}

TEST(ReportVerdict, SaysWhatToDo) {
  using enum Verdict::Kind;
  const auto verdict = [](const json::object& document) { return verdict_of(document); };
  EXPECT_EQ(verdict(full_document(6)).kind, Use);
  json::object document = full_document(6);
  document["verdict"] = {{"color", "amber"},
                         {"findings",
                          {{{"severity", "warning"},
                            {"code", "V_OUTLIERS"},
                            {"sentence", "two rows are far off"},
                            {"what_to_do", ""}}}}};
  EXPECT_EQ(verdict(document).kind, Caution);
  EXPECT_EQ(verdict(document).sentence, "Look into this before you use the model. Two rows are far off.");
  EXPECT_EQ(why_unusable(document), "two rows are far off.");
  document.erase("verdict");
  EXPECT_EQ(verdict(document).kind, Refuse);
  EXPECT_THAT(verdict(document).sentence,
              HasSubstr("The document has no verdict. Make it again with truepose calibrate."));
}

TEST(ReportCloud, DrawsEveryArrowInEveryViewAndTheSameFactorInBeforeAndAfter) {
  const pugi::xml_document page = parsed(render_html(full_document(30)));
  std::vector<std::string> titles;
  for (const pugi::xpath_node& title : page.select_nodes("//div[@class='cloud']//h3")) {
    titles.push_back(text_of(title.node()));
  }
  ASSERT_EQ(titles.size(), 3U);
  EXPECT_EQ(titles[0].substr(titles[0].find(',')), titles[1].substr(titles[1].find(',')));
  EXPECT_THAT(titles[2], HasSubstr("After, enlarged, errors drawn "));
  for (const pugi::xpath_node& view : page.select_nodes("//div[@class='cloud']//svg")) {
    EXPECT_EQ(view.node().select_nodes(".//line[@class='arrow']").size(), 30U);
  }
  EXPECT_EQ(page.select_nodes("//div[@class='cloud']//svg").size(), 6U);
}

TEST(ReportCloud, ThinsOutVeryManyPointsAndSaysSo) {
  const std::string html = render_html(sample_document(600, true));
  EXPECT_THAT(html, HasSubstr("200 of 600 points, evenly chosen."));
  EXPECT_LT(html.size(), 1'500'000U);
}

TEST(ReportJoints, ShowAnErrorAlongAJointsMotionOverThatJoint) {
  json::object document = sample_document(40, true);
  // Joint 1 turns about the base's z axis: an error along it is tangential.
  for (json::value& point : document["points"].as_array()) {
    for (const char* stage : {"geometric", "after"}) point.as_object()[stage] = {0, 0, 0.3};
  }
  document["base"] = {{"x", 0}, {"y", 0}, {"z", 0}, {"rx", 0}, {"ry", 0}, {"rz", 0}};
  const pugi::xml_document page = parsed(render_html(document));
  const auto labels = page.select_nodes("//svg[@aria-label='Joint 1, mm']//title");
  ASSERT_EQ(labels.size(), 40U * 2);  // geometric and all layers
  for (const pugi::xpath_node& label : labels) EXPECT_THAT(text_of(label.node()), HasSubstr(": 0.000 mm"));
  EXPECT_EQ(page.select_nodes("//svg[@aria-label='Joint 1, mm']//path[@class='curve']").size(), 2U);
}

TEST(RawData, IsAMeasurementFileWithQuotedNamesAndTheColumnsThatAllPointsHave) {
  record::Point first{
      .pose = 4, .smr = R"(a "b", c)", .joints = {1.5, -90}, .sigma = 0.01, .direction = {1, -1}};
  first.position = {1, 2.25, 3};
  record::Point second{
      .pose = 7, .set = PoseSet::Validate, .smr = "2", .joints = {0, 1e-7}, .direction = {0, 1}};
  second.position = {4, 5, 6};
  EXPECT_EQ(measurements_csv({first, second}),
            "q1,q2,x,y,z,dir1,dir2,smr,set,pose\n"
            "1.5,-90,1,2.25,3,1,-1,\"a \"\"b\"\", c\",identify,4\n"
            "0,1e-07,4,5,6,0,1,\"2\",validate,7\n");
}

TEST(RawData, IsNotOfferedWhereAnOlderDocumentDoesNotSayWhereThePointsWere) {
  json::object document = sample_document(5, true);
  for (json::value& point : document["points"].as_array()) point.as_object().erase("position");
  const std::string html = render_html(document);
  EXPECT_THAT(html, Not(HasSubstr("measurements.csv")));
  EXPECT_THAT(html, Not(HasSubstr("Where the errors are")));
}

/// A tool whose orientation was not measured.
json::object tool_document() {
  record::FrameDocument tool{.number = 3,
                             .sigma_mm = {0.01, 0.02, 0.03},
                             .sigma0 = 1.1,
                             .readings = {{1, "origin", 0.012}, {2, "origin", 0.034}},
                             .points = {{"origin", {}, {}}},
                             .notes = {"a < b"},
                             .krl = "TOOL_DATA[3]={X 1.0}"};
  tool.X.translation() = Eigen::Vector3d(1, 2, 3);
  return record::frame_document(tool);
}

TEST(FrameSection, IsASectionOfACalibrationsPage) {
  json::object tool = tool_document();
  const std::string html = render_html(sample_document(5, true), {.frame = &tool});
  const pugi::xml_document page = parsed(html);
  EXPECT_EQ(text_of(page.select_node("//table[@class='frame']/tbody/tr[1]").node()),
            "Measured1.00002.00003.00000.000000.000000.00000");
  EXPECT_EQ(text_of(page.select_node("//table[@class='frame']/tbody/tr[2]").node()),
            "Standard deviation0.01000.02000.0300---");
  EXPECT_THAT(html, AllOf(HasSubstr("Tool 3"), HasSubstr("a &lt; b"), HasSubstr("TOOL_DATA[3]={X 1.0}"),
                          HasSubstr("download=\"frame.json\"")));
  EXPECT_THAT(html, Not(HasSubstr("Not to be used")));
  tool["outliers"] = json::array{2};
  EXPECT_THAT(render_html(sample_document(5, true), {.frame = &tool}), HasSubstr("Not to be used: row 2"));
  tool["outliers"] = json::array{};
  tool["base_shift"] =
      json::parse(R"({"p": {"x": 0, "y": 0.3, "z": 0.4}, "sigma_mm": [0.03, 0, 0.04], "significant": true})");
  EXPECT_THAT(render_html(sample_document(5, true), {.frame = &tool}),
              HasSubstr("tracker stands 0.50 mm from where the model has it (standard deviation 0.05 mm)"));
  tool.erase("krl");
  EXPECT_THROW(render_html(sample_document(5, true), {.frame = &tool}), std::invalid_argument);
}

json::object iso_document() {
  return json::parse(R"({"standard": "ISO 9283:1998", "frame": "fitted", "cycles": 10, "complete": false,
      "sets": [{"point": "P<1>", "direction": "+x", "time": "0 min", "cycles": 10,
                "AP": {"p": 0.12345, "x": 0.1, "y": -0.05, "z": 0.02}, "RP": {"l": 0.0678, "mean": 0.02, "std": 0.01}}],
      "variations": [{"point": "P<1>", "time": "", "directions": ["+x", "-x"], "vAP": {"p": 0.031}}],
      "drifts": [{"point": "P<1>", "direction": "", "times": ["0 min", "60 min"], "dAP": {"p": 0.004},
                  "dRP": {"l": 0.003}, "moved": 0.011}]})")
      .as_object();
}

TEST(Iso9283Report, ShowsEverySetItsVariationAndDriftAndWhetherItComplies) {
  const std::string html =
      render_iso9283_html(iso_document(), "test <1>.csv", {{"cycles.csv", "text/csv", "a", "b"}});
  const pugi::xml_document page = parsed(html);
  std::vector<std::string> cells;
  for (const pugi::xpath_node& cell : page.select_nodes("//table[@class='iso9283']/tbody/tr/*")) {
    cells.push_back(text_of(cell.node()));
  }
  EXPECT_THAT(cells, ElementsAre("P<1>, +x, 0 min", "10", "0.1235", "0.1000", "-0.0500", "0.0200", "0.0678"));
  EXPECT_THAT(html, HasSubstr("some poses have 10: these figures do not comply"));
  EXPECT_THAT(html, HasSubstr("AP is relative to that fit"));
  EXPECT_THAT(html, HasSubstr("href=\"data:text/csv;base64,YQ==\""));
  EXPECT_THAT(html, HasSubstr("vAP<sub>p</sub> 0.0310 mm over 2 directions"));
  EXPECT_THAT(html, HasSubstr("from 0 min to 60 min; the mean position moved by 0.0110 mm"));
}

TEST(Iso9283Report, NamesTheMemberThatIsMissing) {
  json::object document = iso_document();
  document["sets"].at(0).at("AP").as_object().erase("p");
  EXPECT_THAT(
      [&] { render_iso9283_html(document, "test.csv", {}); },
      testing::ThrowsMessage<std::invalid_argument>("ISO 9283 document: sets[0].AP: missing key 'p'"));
}

}  // namespace
}  // namespace truepose::report
