// The experiment as its users run it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <pugixml.hpp>
#include <string>
#include <vector>

#include "proto/record/json_io.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/printed_document.hpp"
#include "tools/experiment/experiment_page.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::HasSubstr;
using testing::StartsWith;

Finished experiment(const std::vector<std::string>& arguments) {
  return run_program("truepose-experiment", arguments);
}

/// The document of one small run, shared by the tests that read it.
const Finished& small_run() {
  static const Finished once = experiment({"--trials", "2", "--seed", "3", "--jobs", "1", "--json"});
  return once;
}

json::object document() { return printed_document(small_run().out).as_object(); }

std::string page_of(const json::object& document) {
  return report::render_experiment_html(record::from_json<ExperimentDocument>(document).value());
}

void expect_statistics(const json::value& statistics) {
  for (const char* name : {"mean", "rms", "max", "min", "std"})
    EXPECT_TRUE(statistics.at(name).is_double()) << name;
  for (const char* axis : {"x", "y", "z"})
    EXPECT_TRUE(statistics.at(axis).at("mean_abs").is_double()) << axis;
}

/// Times are the one thing that two runs may differ in.
json::object without_times(json::object of) {
  for (json::value& method : of.at("methods").as_array()) method.as_object().erase("time_s");
  return of;
}

TEST(ExperimentCommand, PrintsOneDocumentWithTheMembersOfTheContract) {
  ASSERT_EQ(small_run().exit_code, 0) << small_run().err;
  EXPECT_EQ(small_run().err, "");
  const json::object all = document();
  EXPECT_EQ(all.at("seed").to_number<int>(), 3);
  EXPECT_EQ(all.at("trials").to_number<int>(), 2);
  EXPECT_EQ(all.at("noise").at("tracker").as_double(), 0.01);
  EXPECT_GT(all.at("bound_rms").as_double(), 0.01);
  for (const json::value& method : all.at("methods").as_array()) {
    expect_statistics(method.at("validation"));
    EXPECT_TRUE(method.at("converged").is_double());
    EXPECT_EQ(method.at("rmse_over_bound").is_null(), method.at("data").as_string() == "noise-free");
  }
  for (const json::value& layer : all.at("layers").as_array()) {
    expect_statistics(layer.at("validation"));
    EXPECT_TRUE(layer.at("poses").is_int64());
    EXPECT_TRUE(layer.at("backlash_deg").is_double());
  }
  for (const json::value& design : all.at("designs").as_array())
    EXPECT_GT(design.at("max").as_double(), design.at("rms").as_double());
  for (const json::value& pair : all.at("published").as_array()) {
    EXPECT_FALSE(pair.at("source").as_string().empty());
    EXPECT_TRUE(pair.at("explanation").as_string().ends_with('.'));
    EXPECT_GT(pair.at("published_mean").as_double(), 0);
    EXPECT_GT(pair.at("mean").as_double(), 0);
  }
}

TEST(ExperimentCommand, GivesTheSameForTheSameSeedWithAnyNumberOfJobsAndWritesTheReport) {
  TempFolder folder;
  const std::string report = folder.path() / "experiment.html";
  const Finished again =
      experiment({"--trials", "2", "--seed", "3", "--jobs", "3", "--json", "--report", report, "--robot",
                  std::string(TRUEPOSE_SOURCE_DIR) + "/config/robots/kr210_r2700_2.yaml"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(without_times(printed_document(again.out).as_object()), without_times(document()));

  // Below it stand the raw data, whose last digits the parser of JSON may round.
  const auto shown = [](const std::string& html) { return html.substr(0, html.find("<h2>Raw data</h2>")); };
  const std::string html = shown(text_of(report));
  EXPECT_TRUE(html == shown(page_of(printed_document(again.out).as_object())));
  EXPECT_GT(html.size(), 10'000U);
}

TEST(ExperimentCommand, RendersAPageThatNeedsNothingElse) {
  const std::string html = page_of(document());
  pugi::xml_document page;
  ASSERT_TRUE(page.load_string(html.c_str()));
  EXPECT_EQ(page.select_nodes("//table").size(), 4u);
  EXPECT_EQ(page.select_nodes("//svg").size(), 4u);
  EXPECT_EQ(page.select_nodes("//svg//g").size(), 16u);  // the methods with noise
  EXPECT_EQ(page.select_nodes("//link | //@src | //@href[not(starts-with(., 'data:'))]").size(), 0u);
  EXPECT_THAT(html, HasSubstr("chosen to match the printed figure"));
}

TEST(ExperimentCommand, RendersAMethodThatNeverConverged) {
  json::object lost = document();
  json::object& method = lost.at("methods").as_array().front().as_object();
  method["validation"] = method["quartiles"] = method["rmse_over_bound"] = nullptr;
  method["converged"] = 0.0;
  method["convergence"] = method["errors"] = json::array{};
  pugi::xml_document page;
  ASSERT_TRUE(page.load_string(page_of(lost).c_str()));
  EXPECT_EQ(page.select_nodes("//svg//g").size(), 15u);
}

TEST(ExperimentCommand, RefusesTrialsAndArmsThatItCannotUse) {
  const Finished none = experiment({"--trials", "0"});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.err, HasSubstr("--trials"));
  EXPECT_EQ(none.out, "");

  TempFolder folder;
  const std::string robot =
      folder.write("robot.yaml",
                   "name: two\njoints:\n"
                   "  - {a: 0, alpha: 0, d: 9, theta: 0, beta: 0, sign: 1, min: -9, max: 9, speed: 1}\n"
                   "  - {a: 9, alpha: 0, d: 0, theta: 0, beta: 0, sign: 1, min: -9, max: 9, speed: 1}\n");
  const Finished two = experiment({"--trials", "2", "--robot", robot});
  EXPECT_EQ(two.exit_code, 2);
  EXPECT_THAT(two.err,
              StartsWith("truepose-experiment: " + robot + ": the experiment needs an arm of six revolute"));
  EXPECT_EQ(two.out, "");
}

}  // namespace
}  // namespace truepose
