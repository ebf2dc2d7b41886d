#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <fstream>
#include <sstream>

#include "config/model_file.hpp"
#include "config/robot_file.hpp"
#include "proto/record/calibration_document.hpp"
#include "tests/daemon/sample_document.hpp"
#include "tests/daemon/sample_path.hpp"
#include "tests/temp_folder.hpp"
#include "tools/truepose/online/online_commands.hpp"
#include "tools/truepose/online/path_report.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;
using testing::HasSubstr;
using testing::internal::CaptureStderr;
using testing::internal::CaptureStdout;
using testing::internal::GetCapturedStderr;
using testing::internal::GetCapturedStdout;

std::string content(const std::filesystem::path& file) {
  std::ifstream in{file};
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

class ReportCommand : public testing::Test {
 protected:
  /// Runs the command on a file that holds `document`.
  int report(const json::value& document, ReportOptions options = {}, bool as_json = false) {
    options.document = folder_.path() / "document.json";
    std::ofstream{options.document} << json::serialize(document);
    CaptureStdout();
    CaptureStderr();
    const int exit_code = exit_code_of([&] { return report_campaign({.json = as_json}, options); });
    out_ = GetCapturedStdout();
    err_ = GetCapturedStderr();
    return exit_code;
  }

  TempFolder folder_;
  std::string out_, err_;
};

TEST_F(ReportCommand, EndsByTheVerdictAsCalibrateDoes) {
  json::object document = report::sample_document(5, true);
  EXPECT_EQ(report(document), 0) << err_;
  document["verdict"] = {{"color", "red"},
                         {"findings",
                          {{{"severity", "error"},
                            {"code", "V_NOT_CONVERGED"},
                            {"sentence", "the identification did not converge"},
                            {"what_to_do", "check the robot file"}}}}};
  EXPECT_EQ(report(document), 1);
  EXPECT_EQ(err_, "truepose: the identification did not converge. Check the robot file.\n");
  document.erase("verdict");
  EXPECT_EQ(report(document), 1) << "nothing looks good that was not judged";
}

TEST_F(ReportCommand, WritesThePageAndTheDocumentWithTheTruthNextToIt) {
  folder_.write("truth.json", json::serialize(report::full_document(5).at("truth")));
  ReportOptions options;
  options.truth = folder_.path() / "truth.json";
  options.html = folder_.path() / "report.html";
  options.json = folder_.path() / "report.json";
  ASSERT_EQ(report(report::sample_document(5, true), options), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("times more accurate"));
  EXPECT_THAT(content(options.html), HasSubstr("</html>"));
  const json::value written = json::parse(content(options.json));
  EXPECT_EQ(written.at("truth"), report::full_document(5).at("truth"));
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "report.html.part"));
}

/// The path file of a program, by the base and the reflector of the sample document.
std::string path_file(const ProductionPath& path) {
  const auto document = record::read_calibration_document(report::sample_document(5, true));
  return report::path_file_of(path, document->base->isometry(), document->smr.at(0).p_FS_mm);
}

TEST_F(ReportCommand, JudgesAProductionProgramByItsPathFileInThePageAndTheDocument) {
  ReportOptions options;
  options.path = folder_.write("path.csv", path_file(report::sample_path()));
  options.html = folder_.path() / "report.html";
  options.json = folder_.path() / "report.json";
  ASSERT_EQ(report(report::sample_document(5, true), options), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("\nProduction: At 2 points of GLUING the reflector was on average 0.150 mm"));
  const json::value written = json::parse(content(options.json));
  EXPECT_EQ(written.at_pointer("/production/points/count"), 2);
  EXPECT_NEAR(written.at_pointer("/production/path/with/max").as_double(), 0.05, 1e-6);
  EXPECT_NEAR(written.at_pointer("/production/points/without/p95").as_double(), 2, 1e-6);

  const auto section = [&] {
    const std::string html = content(options.html);
    const std::size_t begin = html.find("<h2>Production program");
    return html.substr(begin, html.find("</section>", begin) - begin);
  };
  const std::string drawn = section();
  EXPECT_THAT(drawn, HasSubstr("aria-label=\"With the correction\""));
  ASSERT_EQ(report(written, {.html = options.html}), 0) << err_;
  EXPECT_EQ(section(), drawn) << "the document holds all that the section is made of";
}

TEST_F(ReportCommand, EndsByAProductionProgramThatCameNoNearer) {
  ProductionPath path = report::sample_path();
  for (PathSample& sample : path.samples) sample.with_mm.z() += 3;
  EXPECT_EQ(report(report::sample_document(5, true), {.path = folder_.write("path.csv", path_file(path))}),
            1);
  EXPECT_EQ(err_, "truepose: in production (GLUING) the correction brings the arm no nearer\n");
}

TEST_F(ReportCommand, JudgesAProductionProgramByACalibrationOfOneReflectorAlone) {
  ReportOptions options;
  options.path = folder_.write("path.csv", path_file(report::sample_path()));
  const std::string refused =
      "truepose: " + options.path.string() +
      ": can only be judged by a calibration with its arm, a base and one reflector\n";
  json::object two = report::sample_document(5, true), without_base = two;
  two["smr"].as_object()["2"] = {{"x", 1}, {"y", 2}, {"z", 3}};
  without_base.erase("base");
  EXPECT_EQ(report(two, options), 2);
  EXPECT_EQ(err_, refused);
  EXPECT_EQ(report(without_base, options), 2);
  EXPECT_EQ(err_, refused);
}

/// A path by a model file alone. The arm is a KR 210 whose base stands at the tracker's origin.
class PathReport : public ReportCommand {
 protected:
  int report_path_of(const ProductionPath& path, const ReportOptions& files = {}, bool as_json = false) {
    ReportOptions options = files;
    options.path =
        folder_.write("path.csv", report::path_file_of(path, model_.cell.base.isometry(), {62, -48, 187}));
    options.robot = kRobot;
    options.model = folder_.write("model.yaml", config::model_yaml(model_));
    CaptureStdout();
    CaptureStderr();
    const int exit_code = exit_code_of([&] { return report_path({.json = as_json}, options); });
    out_ = GetCapturedStdout();
    err_ = GetCapturedStderr();
    return exit_code;
  }

  static constexpr const char* kRobot = TRUEPOSE_SOURCE_DIR "/config/robots/kr210_r2700_2.yaml";
  RobotModel nominal_ = config::load_robot(kRobot);
  config::ModelFile model_{.name = nominal_.name,
                           .cell = {.robot = nominal_, .reflectors = {{"1", {62, -48, 187}}}}};
};

TEST_F(PathReport, NeedsNoDaemonAndNoCampaign) {
  ReportOptions options;
  options.html = folder_.path() / "report.html";
  options.json = folder_.path() / "report.json";
  ASSERT_EQ(report_path_of(report::sample_path(), options), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("Production: At 2 points of GLUING the reflector was on average 0.150 mm"));
  EXPECT_THAT(content(options.html), HasSubstr("<h2>Production program GLUING</h2>"));
  const json::value written = json::parse(content(options.json));
  EXPECT_EQ(written.at_pointer("/production/points/count"), 2);
  EXPECT_EQ(written.at("robot"), json::value(nominal_.name));
  ASSERT_EQ(report_path_of(report::sample_path(), {}, true), 0) << err_;
  EXPECT_EQ(json::parse(out_).at("production"), written.at("production"));
}

TEST_F(PathReport, IsOfOneReflector) {
  model_.cell.reflectors.push_back({"2", {1, 2, 3}});
  EXPECT_EQ(report_path_of(report::sample_path()), 2);
  EXPECT_THAT(
      err_,
      HasSubstr("model.yaml: has 2 reflectors, and a path is of one. Give a model with one reflector."));
}

TEST_F(ReportCommand, SaysHowAPathIsJudgedWithoutADaemonWhereThereIsNone) {
  const OnlineOptions nobody{{.daemon = (folder_.path() / "control.sock").string()}};
  ReportOptions options;
  options.path = folder_.write("path.csv", path_file(report::sample_path()));
  CaptureStderr();
  EXPECT_EQ(exit_code_of([&] { return report_campaign(nobody, options); }), 3);
  EXPECT_THAT(GetCapturedStderr(),
              HasSubstr("; without a daemon, judge " + options.path.string() +
                        " by --robot FILE --model FILE, by --document FILE or by --store FILE\n"));
}

TEST_F(ReportCommand, PrintsTheDocumentAndNothingElseAsJson) {
  ASSERT_EQ(report(report::sample_document(5, true), {}, true), 0) << err_;
  EXPECT_TRUE(json::parse(out_).at("converged").as_bool());
}

TEST_F(ReportCommand, RefusesADocumentThatItCannotReadAndWritesNothing) {
  json::object broken = report::sample_document(5, true);
  broken["identify"] = 3;
  ReportOptions options;
  options.html = folder_.path() / "report.html";
  EXPECT_EQ(report(broken, options), 2);
  EXPECT_THAT(err_, HasSubstr("the document cannot be reported: "));
  EXPECT_FALSE(std::filesystem::exists(options.html));

  options.truth = folder_.path() / "nothing.json";
  EXPECT_EQ(report(report::sample_document(5, true), options), 2);
  EXPECT_THAT(err_, HasSubstr("nothing.json: cannot be opened: No such file or directory"));
}

TEST_F(ReportCommand, ReadsADocumentThatAnEditorPutAByteOrderMarkBefore) {
  ReportOptions options;
  options.html = folder_.path() / "report.html";
  options.truth = folder_.write("truth.json", "\xef\xbb\xbf[]");
  EXPECT_EQ(report(report::sample_document(5, true), options), 2);
  EXPECT_THAT(err_, HasSubstr("truth.json: not a JSON object"));
}

TEST_F(ReportCommand, SaysWhichFileCannotBeWritten) {
  ReportOptions options;
  options.html = folder_.path() / "no folder" / "report.html";
  EXPECT_EQ(report(report::sample_document(5, true), options), 2);
  EXPECT_THAT(err_, HasSubstr("report.html: cannot be written"));
}

}  // namespace
}  // namespace truepose::tools
