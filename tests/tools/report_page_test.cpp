// The report as its readers have it: opened in a browser, computed again from what it carries, and its
// document against the schema.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "config/measurement_file.hpp"
#include "config/robot_file.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/simulate/measurement_campaign.hpp"
#include "tests/daemon/page.hpp"
#include "tests/process.hpp"
#include "tests/report_schema.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/browser.hpp"
#include "tests/tools/printed_document.hpp"
#include "tests/tools/unmarked.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Six joints with masses and a flange that is turned.
constexpr std::string_view kArm = R"(name: "Arm <6>"
joints:
  - {a: 0, alpha: 0, d: 645, theta: 0, sign: -1, min: -185, max: 185, speed: 116.8, mass: {kg: 190, x: 520, y: 0, z: 90}}
  - {a: 330, alpha: -90, d: 0, theta: 0, sign: 1, min: -140, max: -5, speed: 111.4, mass: {kg: 120, x: 400, y: 10, z: 0}}
  - {a: 1150, alpha: 0, d: 0, theta: -90, sign: 1, min: -120, max: 168, speed: 112, mass: {kg: 150, x: 90, y: 0, z: 30}}
  - {a: 115, alpha: -90, d: 1220, theta: 0, sign: -1, min: -350, max: 350, speed: 179, mass: {kg: 60, x: 0, y: 0, z: -50}}
  - {a: 0, alpha: 90, d: 0, theta: 0, sign: 1, min: -125, max: 125, speed: 172, mass: {kg: 25, x: 0, y: 0, z: 10}}
  - {a: 0, alpha: -90, d: 215, theta: 180, sign: -1, min: -350, max: 350, speed: 220, mass: {kg: 5, x: 0, y: 0, z: -20}}
flange: {x: 10, y: 20, z: 30, a: 40, b: 50, c: 60}
payload: {kg: 80, x: 0, y: 0, z: 200}
gravity: {x: 0, y: 1, z: -1}
)";

// Asks the page in the browser, and leaves the answers as JSON in it.
constexpr std::string_view kProbe = R"html(<script>
(async function () {
  const probe = { downloads: {}, marks: {} };
  for (const link of document.querySelectorAll("a[download]")) {
    probe.downloads[link.download] = await (await fetch(link.href)).text();
  }
  document.querySelectorAll("svg").forEach(function (svg) {
    probe.marks[svg.getAttribute("aria-label")] = svg.querySelectorAll("circle, rect, path, line").length;
  });
  const svg = document.querySelector("svg.turns");
  const places = function () {
    return Array.from(svg.querySelectorAll("line.arrow")).map(function (line) {
      return ["x1", "y1", "x2", "y2"].map(function (name) { return Number(line.getAttribute(name)); });
    });
  };
  probe.drawn = places();
  turn(svg, 0, 0);
  probe.still = places();
  turn(svg, 40, 20);
  probe.turned = places();
  document.querySelectorAll(".cloud label")[1].click();
  probe.shown = Array.from(document.querySelectorAll(".views")).map(function (views) {
    return getComputedStyle(views).display;
  });
  probe.wide = document.documentElement.scrollWidth > document.documentElement.clientWidth;
  const pre = document.createElement("pre");
  pre.id = "probe";
  pre.textContent = btoa(unescape(encodeURIComponent(JSON.stringify(probe))));
  document.body.append(pre);
})();
</script></body>)html";

/// A simulated arm with link errors, measured with noise: two reflectors, one of a hostile name, a payload,
/// and two outliers.
class ReportPage : public testing::Test {
 protected:
  ReportPage() {
    CalibratedCell cell{.robot = nominal_, .base = {{3200, -1450, 780}, {0.01, -0.02, 2.4}}};
    cell.robot.joints[1].a_mm += 0.8;
    cell.robot.joints[4].theta_rad += 1e-3;
    MeasurementData data{.smr_names = {"left", "</script><b>\"x\", &amp;"}};
    cell.reflectors = {{"left", {62, -48, 187}}, {"right", {-62, 48, 150}}};
    Random random{20260508};
    for (const JointVector& q : random_poses(nominal_, 40, random)) {
      const bool validates = data.points.size() >= 56;
      for (int smr = 0; smr < 2; ++smr) {
        const Eigen::Vector3d noise_mm(random.normal(), random.normal(), random.normal());
        data.points.push_back({.q = q,
                               .p_WS_mm = cell.predict(q, smr) + 0.03 * noise_mm,
                               .smr = smr,
                               .set = validates ? PoseSet::Validate : PoseSet::Identify,
                               .sigma_mm = 0.03});
      }
    }
    data.points[4].p_WS_mm.z() += 20;
    data.points[31].p_WS_mm.x() -= 9;
    std::ofstream out(data_);
    config::write_measurements(out, data, nominal_);
  }

  std::string path(const std::string& name) const { return folder_.path() / name; }

  json::object calibrate(std::vector<std::string> options) const {
    options.insert(options.begin(), {"calibrate", "--json", "--loss", "tukey"});
    const Finished run = run_program("truepose", options);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return printed_document(run.out).as_object();
  }

  TempFolder folder_;
  std::string arm_ = folder_.write("arm.yaml", std::string(kArm));
  RobotModel nominal_ = config::load_robot(arm_);
  std::string data_ = path("data.csv");
};

/// The same but for the last digits of numbers.
void expect_near(const json::value& a, const json::value& b, const std::string& where) {
  if (a.is_object()) {
    for (const auto& [key, value] : a.as_object())
      expect_near(value, b.at(key), where + "/" + std::string(key));
  } else if (a.is_array()) {
    ASSERT_EQ(a.as_array().size(), b.as_array().size()) << where;
    for (std::size_t i = 0; i < a.as_array().size(); ++i) expect_near(a.at(i), b.at(i), where);
  } else if (a.is_number()) {
    EXPECT_NEAR(a.to_number<double>(), b.to_number<double>(), 1e-7) << where;
  } else {
    EXPECT_EQ(a, b) << where;
  }
}

/// What the probe finds on the page, of which the browser has no complaint.
json::value probed(std::string html) {
  EXPECT_THAT(browse(html).console, IsEmpty());
  html.replace(html.find("</body>"), 7, kProbe);
  EXPECT_THAT(browse(html).console, ElementsAre(HasSubstr("violates the following Content Security Policy")))
      << "of no script but its own";
  const auto policy = html.find("<meta http-equiv=\"Content-Security-Policy\"");
  html.erase(policy, html.find('>', policy) + 1 - policy);
  const Browsed browsed = browse(html);
  EXPECT_THAT(browsed.console, IsEmpty());
  const std::string_view mark = "<pre id=\"probe\">";
  const std::size_t begin = browsed.dom.find(mark);
  EXPECT_NE(begin, std::string::npos) << browsed.dom.substr(0, 2000);
  if (begin == std::string::npos) return {};
  const std::size_t end = browsed.dom.find('<', begin + mark.size());
  return json::parse(report::base64_decoded(
      std::string_view(browsed.dom).substr(begin + mark.size(), end - begin - mark.size())));
}

TEST_F(ReportPage, OpensInABrowserWithoutAComplaintAndItsChartsDownloadsSwitchAndTurningWork) {
  const json::object document =
      calibrate({"--robot", arm_, "--data", data_, "--report", path("report.html")});
  const std::string html = text_of(path("report.html"));
  const std::map<std::string, std::string> files = report::downloads_of(html);
  const json::value probe = probed(html);

  ASSERT_EQ(probe.at("downloads").as_object().size(), 3U);
  for (const auto& [name, content] : files)
    EXPECT_EQ(probe.at("downloads").at(name).as_string(), content) << name;
  expect_near(document, json::parse(files.at("report.json")), "");

  // Two stages of 24 validation points, and the axes' lines.
  for (const char* chart :
       {"3-D error, mm, logarithmic", "Error along x, mm", "Joint 1, mm", "Joint 6, mm"}) {
    EXPECT_GT(probe.at("marks").at(chart).as_int64(), 24) << chart;
  }
  for (const char* chart : {"Before", "Geometric", "From the side", "From above"}) {
    EXPECT_GT(probe.at("marks").at(chart).as_int64(), 5) << chart;
  }
  EXPECT_GE(probe.at("marks").as_object().size(), 14U);
  EXPECT_EQ(probe.at("wide"), false);
  EXPECT_EQ(probe.at("shown"), (json::value{"none", "block", "none"}));

  // The script projects as the page was drawn; what was drawn is in tenths.
  const json::array &drawn = probe.at("drawn").as_array(), &still = probe.at("still").as_array();
  ASSERT_EQ(drawn.size(), 24U);
  double moved = 0;
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_NEAR(drawn[i].at(k).to_number<double>(), still[i].at(k).to_number<double>(), 0.31);
      moved +=
          std::abs(probe.at("turned").at(i).at(k).to_number<double>() - still[i].at(k).to_number<double>());
    }
  }
  EXPECT_GT(moved, 100);
}

TEST_F(ReportPage, ShowsAProductionProgramInABrowserAndKeepsToTheSchema) {
  json::object document = calibrate({"--robot", arm_, "--data", data_});
  const json::object& smr = document.at("smr").as_object();
  document["smr"] = {{smr.begin()->key(), smr.begin()->value()}};
  // Where tracker and reflector are does not matter to whether it is drawn.
  std::ostringstream rows;
  rows << "time_s,program,point,gain_percent,flange_x_mm,flange_y_mm,flange_z_mm,flange_a_deg,flange_b_deg,"
          "flange_c_deg,with_x_mm,with_y_mm,with_z_mm,without_x_mm,without_y_mm,without_z_mm\n";
  for (int k = 0; k < 50; ++k) {
    const int x = 1500 + 4 * k;
    for (int point = 0; point <= (k % 10 == 9 ? 1 : 0); ++point) {
      rows << 0.02 * k << ",GLUING," << point << ',' << std::min(10 * k, 100) << ',' << x
           << ",-400,900,0,0,0," << x << ",-400,900.1," << x << ",-401,900\n";
    }
  }
  const std::string path_file = folder_.write("path.csv", rows.str()),
                    document_file = folder_.write("document.json", json::serialize(document));
  run_program("truepose", {"report", "--document", document_file, "--path", path_file, "--html",
                           path("report.html"), "--out-json", path("report.json")});
  EXPECT_EQ(report_schema_errors({path("report.json")}), "");
  const json::value probe = probed(text_of(path("report.html")));
  EXPECT_THAT(probe.at("downloads").at("production.csv").as_string(), HasSubstr("GLUING"));
  const json::value& marks = probe.at("marks");
  // Five points and both paths; every sample with all of the correction, twice.
  EXPECT_GE(marks.at("Without the correction").as_int64(), 7);
  EXPECT_GE(marks.at("With the correction").as_int64(), 7);
  EXPECT_GT(marks.at("Distance from the wanted path, mm, logarithmic").as_int64(), 2 * 40);
  EXPECT_GT(marks.at("Error at the points, mm, logarithmic").as_int64(), 2 * 4);
  EXPECT_EQ(probe.at("wide"), false);
}

TEST_F(ReportPage, IsFoundOutWhereItsScriptFailsOrAFileIsMissing) {
  const Browsed browsed = browse(
      "<!DOCTYPE html><html><head></head><body><img "
      "src=\"missing.png\"/><script>nothing();</script></body></html>");
  EXPECT_THAT(browsed.console,
              testing::IsSupersetOf({HasSubstr("missing.png"), HasSubstr("nothing is not defined")}));
}

TEST_F(ReportPage, CarriesAllThatIsNeededToComputeItAgain) {
  const json::object document =
      calibrate({"--robot", arm_, "--data", data_, "--report", path("report.html")});
  for (const auto& [name, content] : report::downloads_of(text_of(path("report.html"))))
    folder_.write(name, content);
  const json::object again = calibrate({"--robot", path("robot.yaml"), "--data", path("measurements.csv")});
  for (const char* member : {"identify", "validate", "rank", "condition", "sigma0_mm", "base", "smr"}) {
    expect_near(document.at(member), again.at(member), member);
  }
  ASSERT_EQ(document.at("rejected").as_array().size(), 2U);
  expect_near(document.at("arm"), again.at("arm"), "arm");
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(document.at("rejected").at(i).at("point"), again.at("rejected").at(i).at("point"));
  }
}

TEST_F(ReportPage, HasADocumentThatKeepsToTheSchemaForEveryKindOfValidation) {
  const std::vector<std::vector<std::string>> kinds{{},
                                                    {"--split", "0.7"},
                                                    {"--split", "0.7", "--repeat", "2"},
                                                    {"--folds", "3"},
                                                    {"--prior", "on"},
                                                    {"--tracker-noise", "0.01,0.006", "--repeatability",
                                                     "0.02", "--non-geometric", "auto", "--residual", "gp"}};
  const std::string all = folder_.write("all.csv", unmarked(text_of(data_)));
  std::vector<std::filesystem::path> documents;
  for (std::vector<std::string> options : kinds) {
    const bool draws = !options.empty() && (options[0] == "--split" || options[0] == "--folds");
    options.insert(options.begin(), {"--robot", arm_, "--data", draws ? all : data_});
    const std::string name = "document" + std::to_string(documents.size()) + ".json";
    documents.push_back(folder_.write(name, json::serialize(calibrate(options))));
  }
  EXPECT_EQ(report_schema_errors(documents), "");

  json::object wrong = json::parse(text_of(documents[0])).as_object();
  wrong["identify"].as_object()["before"].as_object()["mean"] = -1;
  wrong["unheard-of"] = 1;
  const std::string errors = report_schema_errors({folder_.write("wrong.json", json::serialize(wrong))});
  EXPECT_THAT(errors, HasSubstr("identify/before/mean: -1 is less than the minimum"));
  EXPECT_THAT(errors, HasSubstr("unheard-of"));
}

}  // namespace
}  // namespace truepose
