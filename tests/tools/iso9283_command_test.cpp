#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "config/model_file.hpp"
#include "config/number_text.hpp"
#include "core/math/angles.hpp"
#include "core/simulate/published_arm.hpp"
#include "tests/core/iso9283_example.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/printed_document.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::HasSubstr;

std::string row(const Eigen::Vector3d& p) {
  return config::format_number(p.x()) + "," + config::format_number(p.y()) + "," +
         config::format_number(p.z()) + "\n";
}

std::string point_name(int k) { return {'P', static_cast<char>('0' + k)}; }

std::string fixed(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%9.4f", value);
  return text;
}

/// The worked example as files: five points, thirty cycles.
class Iso9283 : public testing::Test {
 protected:
  std::string targets() {
    std::string text = "point,x,y,z\n";
    for (int k = 1; k <= 5; ++k) text += point_name(k) + "," + row(example::commanded_mm(k));
    return folder_.write("targets.csv", text);
  }

  /// @param X_MB  the robot's base in the measuring frame
  std::string data(const Eigen::Isometry3d& X_MB = Eigen::Isometry3d::Identity(), int cycles = 30) {
    std::string text = "point,cycle,x,y,z\n";
    for (int j = 1; j <= cycles; ++j) {
      for (int k = 1; k <= 5; ++k) {
        text += point_name(k) + "," + std::to_string(j) + "," +
                row(X_MB * (example::commanded_mm(k) + example::deviation_mm(k, j)));
      }
    }
    return folder_.write("data.csv", text);
  }

  static json::object succeed(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "iso9283");
    arguments.push_back("--json");
    const Finished run = run_program("truepose", arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.err, "");
    return printed_document(run.out).as_object();
  }

  static double number(const json::value& set, const char* characteristic, const char* part) {
    return set.at(characteristic).at(part).to_number<double>();
  }

  TempFolder folder_;
};

TEST_F(Iso9283, WritesAReportThatCarriesWhatItWasMadeFrom) {
  const std::string report = folder_.path() / "report.html";
  const Finished run =
      run_program("truepose", {"iso9283", "--data", data(), "--targets", targets(), "--report", report});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const std::string html = text_of(report);
  for (const example::WorkedFigures& w : example::kWorkedFigures) {
    for (const double figure : {w.ap_p, w.rp_l}) {
      std::string cell = fixed(figure);
      cell.erase(0, cell.find_first_not_of(' '));
      EXPECT_NE(html.find(">" + cell + "</td>"), std::string::npos) << cell;
    }
  }
  for (const char* file : {"cycles.csv", "targets.csv", "iso9283.json"})
    EXPECT_NE(html.find("download=\"" + std::string(file) + "\""), std::string::npos) << file;
}

TEST_F(Iso9283, BringsTrackerDataIntoTheBaseOfAModel) {
  const CalibratedCell cell{.robot = published_arm(),
                            .base = {.p_mm = {4000, 500, -300}, .rxyz_rad = {0.1, -0.2, 2.1}}};
  const std::string model = folder_.write("model.yaml", config::model_yaml({.name = "r", .cell = cell}));
  const json::object document =
      succeed({"--data", data(cell.base.isometry()), "--targets", targets(), "--model", model});
  EXPECT_EQ(document.at("frame"), "model");
  EXPECT_EQ(document.at("complete"), true);
  const json::array& sets = document.at("sets").as_array();
  ASSERT_EQ(sets.size(), 5U);
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_NEAR(number(sets[k], "AP", "x"), example::kWorkedFigures[k].ap_x, 1e-9);
    EXPECT_NEAR(number(sets[k], "RP", "l"), example::kWorkedFigures[k].rp_l, 1e-9);
    EXPECT_FALSE(sets[k].at("AP").as_object().contains("a"));
  }
}

TEST_F(Iso9283, NamesACommandedPoseThatNoCycleCameTo) {
  std::string text = text_of(data());
  for (std::size_t row = text.find("P3,"); row != std::string::npos; row = text.find("P3,"))
    text.erase(row, text.find('\n', row) + 1 - row);
  const std::string without = folder_.write("without.csv", text);
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--fit-frame"}}) {
    std::vector<std::string> arguments{"--data", without, "--targets", targets()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const json::object document = succeed(arguments);
    EXPECT_EQ(document.at("complete"), false);
    EXPECT_EQ(document.at("cycles"), 0);
    EXPECT_EQ(document.at("missing"), (json::array{"P3"}));
    EXPECT_EQ(document.at("sets").as_array().size(), 4U);
  }
  EXPECT_FALSE(succeed({"--data", data(), "--targets", targets()}).contains("missing"));

  const std::string report = folder_.path() / "report.html";
  const Finished run =
      run_program("truepose", {"iso9283", "--data", without, "--targets", targets(), "--report", report});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const std::string said =
      "No cycle came to P3: these figures do not hold there, as the standard asks for 30 cycles at every "
      "commanded pose, and they do not comply.";
  EXPECT_NE(run.out.find(said), std::string::npos) << run.out;
  EXPECT_NE(text_of(report).find(said), std::string::npos);
}

TEST_F(Iso9283, RefusesPositionsInOtherUnitsOrColumns) {
  const auto refused = [&](const std::string& measured, const std::string& commanded,
                           const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"iso9283", "--data", measured, "--targets", commanded};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Finished run = run_program("truepose", arguments);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_EQ(run.out, "");
    return run.err;
  };
  const auto rewritten = [&](const char* name, const Eigen::Matrix3d& by, bool are_targets) {
    std::string text = are_targets ? "point,x,y,z\n" : "point,cycle,x,y,z\n";
    for (int j = 1; j <= (are_targets ? 1 : 30); ++j) {
      for (int k = 1; k <= 5; ++k) {
        const Eigen::Vector3d off = are_targets ? Eigen::Vector3d(0, 0, 0) : example::deviation_mm(k, j);
        text += point_name(k) + "," + (are_targets ? "" : std::to_string(j) + ",") +
                row(by * (example::commanded_mm(k) + off));
      }
    }
    return folder_.write(name, text);
  };
  const Eigen::Matrix3d to_m = 1e-3 * Eigen::Matrix3d::Identity();
  Eigen::Matrix3d swap;
  swap << 0, 1, 0, 1, 0, 0, 0, 0, 1;
  const std::string in_m = rewritten("m.csv", to_m, false), targets_in_m = rewritten("tm.csv", to_m, true);
  const std::string falls =
      ": with them converted the largest distance from a commanded position falls from ";
  EXPECT_THAT(refused(in_m, targets()),
              HasSubstr(in_m + ": the measured positions are in m, not mm" + falls));
  EXPECT_THAT(refused(in_m, targets(), {"--fit-frame"}),
              HasSubstr(in_m + ": the measured positions are in m, not mm" + falls));
  EXPECT_THAT(refused(data(), targets_in_m), HasSubstr(": the commanded positions are in m, not mm" + falls));
  EXPECT_THAT(
      refused(rewritten("swapped.csv", swap, false), targets()),
      HasSubstr(
          ": the columns of the measured or the commanded positions are swapped: with x,y,z measured taken "
          "from y,x,z the largest distance"));
  EXPECT_THAT(
      refused(data(pose_from_kuka({4000, 500, -300}, {120, 3, -2})), targets()),
      HasSubstr(" mm from where it was commanded, which no arm is wrong by: check the names of the points "
                "and in which frame both stand"));
}

TEST_F(Iso9283, ShowsVariationAndDriftWhereTheyWereMeasured) {
  std::string text = "point,cycle,direction,time,x,y,z,a,b,c,cx,cy,cz,ca,cb,cc\n";
  for (const int minute : {0, 60}) {
    for (const char* direction : {"+x", "+y", "+z"}) {
      for (int cycle = 1; cycle <= 3; ++cycle) {
        const double x = 1000 + 0.001 * cycle + 0.0005 * minute + (direction[1] == 'z' ? 0.02 : 0);
        text += "P1," + std::to_string(cycle) + "," + direction + "," + std::to_string(minute) + " min," +
                config::format_number(x) + ",0,800,0.01,90,0,1000,0,800,0,90,0\n";
      }
    }
  }
  const std::string file = folder_.write("data.csv", text);
  const json::object document = succeed({"--data", file});
  ASSERT_EQ(document.at("variations").as_array().size(), 2U);
  EXPECT_NEAR(number(document.at("variations").at(0), "vAP", "p"), 0.02, 1e-9);
  ASSERT_EQ(document.at("drifts").as_array().size(), 3U);
  EXPECT_NEAR(number(document.at("drifts").at(0), "dAP", "p"), 0.03, 1e-9);
  EXPECT_NEAR(number(document.at("sets").at(0), "AP", "c"), 0.01 * kRadPerDeg, 1e-12);
  const Finished run = run_program("truepose", {"iso9283", "--data", file});
  EXPECT_NE(run.out.find("P1 0 min: vAP_p 0.0200 mm over 3 directions"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("P1 +x: dAP_p 0.0300, dRP_l 0.0000 mm from 0 min to 60 min"), std::string::npos)
      << run.out;
}

}  // namespace
}  // namespace truepose
