#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json/object.hpp>
#include <boost/json/parse.hpp>
#include <boost/json/value.hpp>

#include "proto/control/json_text.hpp"
#include "tests/daemon/page.hpp"
#include "tests/integration/live_cell.hpp"
#include "tests/integration/sqlite_rows.hpp"
#include "tests/report_schema.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::AllOf;
using testing::HasSubstr;

/// To the last digits that a file of points keeps.
void expect_same_calibration(const json::value& a, const json::value& b) {
  for (const char* member :
       {"/method", "/converged", "/rank", "/observability/not_identifiable", "/prior/used"})
    EXPECT_EQ(a.at_pointer(member), b.at_pointer(member)) << member;
  for (const char* member : {"/identify/before/mean", "/identify/after/max", "/validate/before/mean",
                             "/validate/after/mean", "/sigma0_mm", "/prediction_uncertainty/max_mm"})
    EXPECT_NEAR(number(a, member), number(b, member), 1e-6) << member;
  const json::array &ours = a.at("parameters").as_array(), &theirs = b.at("parameters").as_array();
  ASSERT_EQ(ours.size(), theirs.size());
  for (std::size_t i = 0; i < ours.size(); ++i) {
    EXPECT_EQ(ours[i].at("name"), theirs[i].at("name"));
    EXPECT_NEAR(number(ours[i], "/value"), number(theirs[i], "/value"), 1e-5) << ours[i].at("name");
    EXPECT_NEAR(number(ours[i], "/sigma"), number(theirs[i], "/sigma"), 1e-6) << ours[i].at("name");
  }
  const json::array &points = a.at("points").as_array(), &same = b.at("points").as_array();
  ASSERT_EQ(points.size(), same.size());
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(points[i].at("pose"), same[i].at("pose"));
}

TEST(ACampaignOverTheRealProtocols, FindsTheArmsErrorsKeepsEveryPointAndActivatesTheModel) {
  LiveCell cell{{.speedup = 1000}};
  cell.start_daemon();
  tools::RpcClient client = cell.client();

  const Finished campaign = small_campaign(cell);
  ASSERT_EQ(campaign.exit_code, 0) << campaign.err << campaign.out << cell.daemon().errors();

  const json::value report = called(client, "report.get").at("document");
  EXPECT_EQ(report.at("rank"), 27);
  EXPECT_TRUE(report.at("converged").as_bool());
  EXPECT_EQ(report.at_pointer("/identify/points"), 12);
  EXPECT_EQ(report.at_pointer("/validate/points"), 6);
  const double before_mm = number(report, "/validate/before/mean");
  EXPECT_GT(before_mm, 1);
  EXPECT_LT(number(report, "/validate/geometric/mean"), before_mm / 5);
  EXPECT_LT(number(report, "/remeasured/mean"), before_mm / 5);

  const std::filesystem::path page = cell.folder() / "report.html", document = cell.folder() / "report.json";
  const Finished reported =
      cell.truepose({"report", "--html", page.string(), "--out-json", document.string()});
  EXPECT_EQ(reported.exit_code, 0) << reported.err;
  EXPECT_EQ(report_schema_errors({document}), "");
  const json::value whole = json::parse(text_of(document));
  EXPECT_EQ(whole.at_pointer("/points/0/time").as_string().back(), 'Z');
  EXPECT_THAT(text_of(page), AllOf(HasSubstr("Use this model"), HasSubstr("measurements.csv"),
                                   HasSubstr("<th scope=\"row\">Air temperature</th>"),
                                   HasSubstr("<td>12 to identify, 6 to validate</td>")));

  // The command, given the files that the page carries, comes to the same numbers and the same verdict.
  for (const auto& [name, content] : report::downloads_of(text_of(page))) cell.write(name, content);
  const Finished offline =
      run_program("truepose", {"calibrate", "--robot", cell.folder() / "robot.yaml", "--data",
                               cell.folder() / "measurements.csv", "--tracker-noise", "0.01,0.003",
                               "--repeatability", "0.0166", "--json"});
  EXPECT_EQ(offline.exit_code, reported.exit_code) << offline.err;
  expect_same_calibration(json::parse(offline.out), whole);

  const json::value status = called(client, "cell.status");
  EXPECT_EQ(status.at("state"), "ready");
  ASSERT_TRUE(status.at("model").is_object());
  EXPECT_TRUE(status.at_pointer("/model/active").as_bool());
  EXPECT_EQ(status.at_pointer("/model/robot_serial"), "210001");

  cell.daemon().terminate();
  EXPECT_EQ(cell.daemon().wait(), 0) << cell.daemon().errors();
  using Rows = std::vector<std::vector<std::string>>;
  EXPECT_EQ(
      sqlite_rows(cell.store_file(), "SELECT purpose, count(*) FROM point GROUP BY purpose ORDER BY purpose"),
      (Rows{{"identify", "12"}, {"reference", "4"}, {"remeasure", "6"}, {"validate", "6"}}));
  EXPECT_EQ(sqlite_rows(cell.store_file(), "SELECT state, reason FROM campaign"), (Rows{{"done", ""}}));
  EXPECT_EQ(sqlite_rows(cell.store_file(), "SELECT active FROM model"), (Rows{{"1"}}));
  EXPECT_EQ(cell.end_simulator().at("measurements"), 28);
}

TEST(AnIso9283CampaignOverTheRealProtocols, GivesTheSameAsTheEvaluationOfItsFile) {
  LiveCell cell{{.speedup = 1000, .cell = {{"\ncontrol:\n", "\niso9283: {variation: true}\ncontrol:\n"}}}};
  cell.start_daemon();
  ASSERT_EQ(small_campaign(cell).exit_code, 0);
  const Finished run = cell.truepose({"campaign", "start", "--kind", "iso9283", "--cycles", "3", "--watch"});
  ASSERT_EQ(run.exit_code, 0) << run.err << run.out << cell.daemon().errors();
  EXPECT_THAT(run.out, AllOf(HasSubstr("cycling"), HasSubstr("42/42 poses"), HasSubstr("AP mm")));

  const std::string cycles = cell.folder() / "cycles.csv", document = cell.folder() / "iso.json",
                    model = cell.folder() / "model.yaml", page = cell.folder() / "page.html";
  const Finished shown = cell.truepose({"campaign", "show", "--cycles", cycles, "--document", document});
  ASSERT_EQ(shown.exit_code, 0) << shown.err;
  EXPECT_THAT(shown.out, AllOf(HasSubstr("\nP1 +x "), HasSubstr("\nP3     3 "), HasSubstr("\nP4: vAP 0.")));
  ASSERT_EQ(cell.truepose({"model", "export", "--out", model}).exit_code, 0);
  const Finished evaluated =
      run_program("truepose", {"iso9283", "--data", cycles, "--model", model, "--json"});
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.err;
  const json::value stored = *control::parse_json(text_of(document));
  const json::value offline = *control::parse_json(evaluated.out);
  EXPECT_EQ(stored.at("frame"), "model");
  EXPECT_EQ(stored.at("cycles"), offline.at("cycles"));
  ASSERT_EQ(stored.at("sets").as_array().size(), 14U);
  for (int k = 0; k < 14; ++k) {
    const std::string set = "/sets/" + std::to_string(k);
    for (const char* what : {"/point", "/direction"})
      EXPECT_EQ(stored.at_pointer(set + what), offline.at_pointer(set + what));
    for (const char* what : {"/AP/p", "/RP/l"})
      EXPECT_NEAR(number(stored, (set + what).c_str()), number(offline, (set + what).c_str()), 1e-6);
    EXPECT_LT(number(stored, (set + "/AP/p").c_str()), 1);
  }
  ASSERT_EQ(stored.at("variations").as_array().size(), 3U);
  for (const char* what : {"/variations/0/vAP/p", "/variations/1/vAP/p", "/variations/2/vAP/p"})
    EXPECT_NEAR(number(stored, what), number(offline, what), 1e-6);
  EXPECT_EQ(cell.truepose({"report", "--iso9283", document, "--html", page}).exit_code, 0);
  EXPECT_THAT(text_of(page), HasSubstr("ISO 9283"));
}

}  // namespace
}  // namespace truepose
