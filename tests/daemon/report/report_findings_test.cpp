// Findings in the reports of a calibration, in addition to its errors and parameters.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>
#include <pugixml.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/report/report.hpp"
#include "tests/daemon/page.hpp"
#include "tests/daemon/sample_document.hpp"

namespace truepose::report {
namespace {

namespace json = boost::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsSupersetOf;
using testing::Not;

constexpr char kWarning[] = "Measure poses towards the joints -90, 80 deg & further <out>";

json::value parsed_map() {
  return json::parse(R"({"x": {"joint": 1, "from": -100, "to": 100, "count": 2},
                         "y": {"joint": 2, "from": -50, "to": 30, "count": 3},
                         "held": [10, 20], "sigma_mm": [[0.1, 0.2], [0.3, 0.4], [0.5, 6]]})");
}

/// A document with something to say of everything.
json::object telling_document() {
  json::object document = sample_document(30, true);
  document["spread"] = json::parse(R"({"over": "splits", "count": 10,
      "before": {"mean": 0.02, "max": 0.1, "rms": 0.03}, "geometric": {"mean": 0.005, "max": 0.05, "rms": 0.006},
      "after": {"mean": 0.003, "max": 0.04, "rms": 0.004}})");
  document["non_geometric"] =
      json::parse(R"({"geometric_rms_mm": 0.266, "rms_mm": 0.1, "scale": 0.003, "groups": [
      {"name": "joint1.harmonic2", "chosen": false, "rms_mm": 0.099},
      {"name": "joint2.gravity", "chosen": true, "rms_mm": 0.125}]})");
  document["residual"] =
      json::parse(R"({"chosen": true, "without_rms_mm": 0.1, "rms_mm": 0.085, "standard_error_mm": 0.002})");
  document["rejected"] = json::parse(R"([
      {"point": 3, "row": 7, "pose": 2, "smr": "left", "residual_mm": 12.5, "sigmas": 300},
      {"point": 4, "row": 8, "residual_mm": 1.5, "sigmas": 30}])");
  json::object& observability = document["observability"].as_object();
  observability["not_identifiable"] =
      json::array{"link2.d and link3.d move together: only their sum is known"};
  observability["weakly_identifiable"] =
      json::array{"link5.beta is weakly known: sigma is 3 times the usual deviation"};
  document["rank_gap"] = 1.3e12;
  document["prior"] = {{"used", true}, {"length_mm", 0.3}, {"angle_rad", 3e-4}};
  document["parameters"].as_array()[3].as_object()["data_share"] = 0.25;
  document["prediction_uncertainty"] = {{"rms_mm", 0.5},
                                        {"max_mm", 6.1},
                                        {"worst_joints", {-90, 80}},
                                        {"warning", kWarning},
                                        {"maps", {parsed_map()}}};
  document["noise"] = {{"range_mm", 0.01}, {"transverse_mm_per_m", 0.006}, {"repeatability_mm", 0.02}};
  return document;
}

std::vector<std::string> texts(const pugi::xml_document& page, const char* path) {
  std::vector<std::string> result;
  for (const pugi::xpath_node& node : page.select_nodes(path)) result.push_back(text_of(node.node()));
  return result;
}

constexpr const char* kSections[] = {"What each layer bought", "How well unmeasured poses are known",
                                     "Points to identify that were left out",
                                     "Not identifiable from the data"};

TEST(ReportFindings, HaveTheirSectionsInAWellFormedPage) {
  const pugi::xml_document page = parsed(render_html(telling_document()));
  EXPECT_THAT(texts(page, "//h2"), IsSupersetOf(kSections));
  EXPECT_FALSE(page.select_node("//script[@src]|//link|//img"));
}

TEST(ReportFindings, AreLeftOutWhereAStoredDocumentDoesNotHoldThem) {
  json::object old = telling_document();
  for (const char* key : {"spread", "non_geometric", "residual", "rejected", "observability", "prior",
                          "prediction_uncertainty", "noise", "rank_gap", "sigma0_mm"}) {
    old.erase(key);
  }
  const std::vector<std::string> headings = texts(parsed(render_html(old)), "//h2");
  for (const char* section : kSections) {
    EXPECT_EQ(std::ranges::count(headings, section), 0) << section;
  }
  const std::string text = render_text(old);
  EXPECT_THAT(text, HasSubstr("parameters determined.\n\nVerdict: green."));
}

TEST(ReportFindings, CountTheGeometricParametersWithoutTheDeviationsOfTheJoints) {
  json::object document = telling_document();
  const auto all = document.at("parameters").as_array().size();
  EXPECT_THAT(render_text(document), HasSubstr("5 of " + std::to_string(all) + " geometric parameters"));
  json::object deviation = document.at("parameters").as_array().back().as_object();
  deviation["name"] = "joint2.sin1";
  document["parameters"].as_array().push_back(deviation);
  EXPECT_THAT(render_text(document), HasSubstr("5 of " + std::to_string(all) + " geometric parameters"));
}

TEST(ReportFindings, ShowTheSpreadOfTheValidationAlone) {
  json::object document = telling_document();
  document["validate"].as_object()["after"].as_object()["mean"] = 0.091;
  const std::string text = render_text(document);
  EXPECT_THAT(text, HasSubstr("Validation: 30 poses, 30 points, mean ± standard deviation over 10 splits\n"));
  EXPECT_THAT(text, HasSubstr("     0.091 ± 0.003\n"));
  const pugi::xml_document page = parsed(render_html(document));
  const std::vector<std::string> rows = texts(page, "//table[@class='statistics']/tbody[1]/tr[4]/td");
  EXPECT_EQ(rows[0], "0.091 ± 0.003");
  EXPECT_THAT(texts(page, "//table[@class='statistics']/tbody[2]//td"),
              Not(testing::Contains(HasSubstr("±"))));
}

TEST(ReportFindings, SayThatFoldsPredictedEveryPose) {
  json::object document = telling_document();
  document["spread"].as_object()["over"] = "folds";
  json::array points;
  for (const json::value& point : document["points"].as_array()) {
    if (point.at("set") == "validate") points.push_back(point);
  }
  document["fold_points"] = points;
  EXPECT_THAT(render_text(document),
              HasSubstr("each pose predicted by the one of 10 fits that had not seen it"));
  EXPECT_THAT(render_html(document), HasSubstr("Cross-validated on 30 poses in 10 folds"));
  document["spread"].as_object()["over"] = "weeks";
  EXPECT_THROW(render_html(document), std::invalid_argument);
}

TEST(ReportFindings, SayWhatEachLayerBought) {
  const json::object document = telling_document();
  const std::string text = render_text(document);
  EXPECT_THAT(text, HasSubstr("Non-geometric errors: cross-validated RMS 0.266 mm -> 0.100 mm\n"
                              "  without joint 2, gravity         0.125 mm, 25.0 % more\n\n"));
  EXPECT_THAT(
      text,
      HasSubstr("Residual field: Gaussian process, cross-validated RMS 0.100 mm -> 0.085 ± 0.002 mm\n"));
  const pugi::xml_document page = parsed(render_html(document));
  EXPECT_THAT(texts(page, "//table[@class='layers']/tbody[2]/tr[3]/*"),
              ElementsAre("joint 2, gravity", "chosen", "0.125", "0.100", "20.0 %", ""));
  EXPECT_THAT(texts(page, "//table[@class='layers']/tbody[2]/tr[4]/*"),
              ElementsAre("joint 1, harmonic 2", "not chosen", "0.100", "0.099", "1.0 %", ""));
  EXPECT_THAT(texts(page, "//table[@class='layers']/tbody[3]/tr[2]/*"),
              ElementsAre("Gaussian process", "chosen", "0.100", "0.085 ± 0.002", "15.0 %", ""));
}

TEST(ReportFindings, SayThatNothingWasChosen) {
  json::object document = telling_document();
  document["non_geometric"].as_object()["groups"].as_array().pop_back();
  document["residual"].as_object()["chosen"] = false;
  const std::string text = render_text(document);
  EXPECT_THAT(text, HasSubstr("Non-geometric errors: none predicts unseen poses better.\n"));
  EXPECT_THAT(text, HasSubstr("Residual field: unseen poses are predicted as well without it.\n"));
}

TEST(ReportFindings, ListRejectedPointsByTheirPlace) {
  const json::object document = telling_document();
  EXPECT_THAT(render_text(document),
              HasSubstr("Points to identify that were left out: 2\n"
                        "  pose 2, reflector left, row 7: 12.500 mm, 300 standard deviations\n"
                        "  row 8: 1.500 mm, 30 standard deviations\n"));
  EXPECT_THAT(texts(parsed(render_html(document)), "//table[@class='rejected']/tbody/tr[1]/*"),
              ElementsAre("pose 2, reflector left, row 7", "12.500", "300"));
}

TEST(ReportFindings, TellA6DTargetsTurnInDegrees) {
  json::object document = telling_document();
  document["rejected"].as_array()[1].as_object()["orientation_error_rad"] = 0.02;
  const json::object statistics{{"mean_rad", 0.01}, {"rms_rad", 0.011}, {"max_rad", 0.02}},
      less{{"mean_rad", 1e-4}, {"rms_rad", 1e-4}, {"max_rad", 2e-4}};
  document["identify"].as_object()["orientation_errors"] = {
      {"readings", 20}, {"before", statistics}, {"after", less}};
  document["targets"] = {{{"smr", "left"}, {"rx", 0.1}, {"ry", 0}, {"rz", -1}, {"sigma_rad", 1e-4}}};
  const std::string text = render_text(document),
                    turns = "mean 0.5730 -> 0.0057 deg, max 1.1459 -> 0.0115 deg";
  EXPECT_THAT(text, HasSubstr("  row 8: turned by 1.146 deg, 30 standard deviations\n"));
  EXPECT_THAT(text,
              HasSubstr("Orientation error of 6-D targets, identification: " + turns + ", 20 readings\n"));
  EXPECT_THAT(text,
              HasSubstr("Target left on the flange: A -57.2958, B 0.0000, C 5.7296 deg, sigma 0.0057 deg\n"));
  const std::string page = render_html(document);
  EXPECT_THAT(texts(parsed(page), "//table[@class='rejected']/tbody/tr[2]/*"),
              ElementsAre("row 8", "turned by 1.146 deg", "30"));
  EXPECT_THAT(page, HasSubstr("Target left on the flange"));
}

TEST(ReportFindings, ListOnlyTheWorstOfManyRejectedPointsOnATerminal) {
  json::object document = telling_document();
  json::array& rejected = document["rejected"].as_array();
  for (int row = 11; row <= 30; ++row) {
    rejected.push_back({{"point", row}, {"row", row}, {"residual_mm", 0.1}, {"sigmas", row}});
  }
  const std::string text = render_text(document);
  EXPECT_THAT(
      text,
      HasSubstr(
          "Points to identify that were left out: 22, the worst 10 of them\n  pose 2, reflector left, row 7"));
  EXPECT_THAT(text, HasSubstr("row 30: "));
  EXPECT_THAT(text, Not(HasSubstr("row 11: ")));
}

TEST(ReportFindings, SayInWordsWhatThePosesLeaveOpen) {
  const json::object document = telling_document();
  const std::string text = render_text(document);
  EXPECT_THAT(text, HasSubstr("Not identifiable from these poses:\n"
                              "  link2.d and link3.d move together: only their sum is known\n\n"
                              "What the data sheet knows better:\n  link5.beta is weakly known"));
  const pugi::xml_document page = parsed(render_html(document));
  EXPECT_EQ(texts(page, "//ul[@class='sentences']/li").size(), 2U);
  EXPECT_THAT(texts(page, "//table[@class='figures']//th"),
              ElementsAre("Rank", "Gap", "Condition", "O1", "O2", "O3", "O4", "O5"));
}

TEST(ReportFindings, SayForWhatShareAPriorSpeaks) {
  const json::object document = telling_document();
  // The three link parameters come from the data by 25, 100 and 0 percent.
  const std::string share =
      "This prior makes up 58 % of what is known of them, and more than half of it for 2 of 3";
  EXPECT_THAT(render_text(document), HasSubstr("0.30 mm, 0.017 deg"));
  EXPECT_THAT(render_text(document), HasSubstr(share));
  const std::string html = render_html(document);
  EXPECT_THAT(html, HasSubstr(share));
  EXPECT_THAT(html, HasSubstr("<th>data share</th>"));
  EXPECT_THAT(html, HasSubstr("<td>25 %</td>"));
  EXPECT_THAT(render_html(sample_document(30, true)), Not(HasSubstr("data share")));
}

TEST(ReportFindings, WarnOfUnmeasuredPosesAndMapThem) {
  json::object document = telling_document();
  EXPECT_THAT(render_text(document), HasSubstr(std::string("Warning: ") + kWarning + "\n"));
  const pugi::xml_document page = parsed(render_html(document));
  EXPECT_THAT(texts(page, "//p[@class='caution']"), ElementsAre(kWarning));
  EXPECT_THAT(texts(page, "//ul[@class='badges']/li[@class='warning']"),
              ElementsAre("Not known well everywhere: measure more poses", "2 points were left out"));
  const std::string map = "//svg[@aria-label='Joints 1 and 2']";
  EXPECT_EQ(page.select_nodes((map + "/rect[title]").c_str()).size(), 6U);
  // Poses from 0 to 17 deg of joint 1, all at 20 of joint 2; those of the validation are not shown.
  EXPECT_EQ(page.select_nodes((map + "/circle").c_str()).size(), 0U);
  document["prediction_uncertainty"].as_object()["maps"].as_array()[0].at("y").as_object()["to"] = 2000;
  EXPECT_EQ(parsed(render_html(document)).select_nodes((map + "/circle").c_str()).size(), 30U);
  document["prediction_uncertainty"].as_object().erase("warning");
  EXPECT_THAT(render_text(document), Not(HasSubstr("Warning")));
  EXPECT_FALSE(parsed(render_html(document)).select_node("//p[@class='caution']"));
}

TEST(ReportFindings, RefuseAMapThatIsNotAGrid) {
  json::object document = telling_document();
  document["prediction_uncertainty"].at("maps").at(0).at("sigma_mm").as_array()[1].as_array().pop_back();
  EXPECT_THAT([&] { render_html(document); },
              testing::ThrowsMessage<std::invalid_argument>(
                  HasSubstr("prediction_uncertainty.maps[0].sigma_mm: expected a number for each x")));
}

}  // namespace
}  // namespace truepose::report
