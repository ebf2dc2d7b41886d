// What pages are made of: tables, plots and the kinds of charts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <pugixml.hpp>
#include <string>
#include <utility>
#include <vector>

#include "config/text_file.hpp"
#include "core/math/random.hpp"
#include "daemon/report/charts.hpp"
#include "daemon/report/page.hpp"
#include "daemon/report/sections.hpp"
#include "tests/daemon/page.hpp"

namespace truepose::report {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

TEST(PageTable, SetsAColumnApartInItsHeadingAsInItsCells) {
  Table table{"sizes", {{}, {"mean", "strong"}, {"max", "text first"}}};
  table.row("before", {"1", "2"});
  table.row("after", {"3", "4"}, "convention");
  EXPECT_EQ(std::move(table).scrolled(),
            "<div class=\"scroll\"><table class=\"sizes\">\n"
            "<thead>\n<tr><th></th><th>mean</th><th class=\"first\">max</th></tr>\n</thead>\n"
            "<tbody>\n<tr><th scope=\"row\">before</th><td class=\"strong\">1</td><td class=\"text "
            "first\">2</td></tr>\n"
            "<tr class=\"convention\"><th scope=\"row\">after</th><td class=\"strong\">3</td><td "
            "class=\"text first\">4</td></tr>\n</tbody>\n</table></div>\n");
}

TEST(PageTable, HasASecondLineOfHeadingsOnlyWhereColumnsAreGrouped) {
  Table table{"", {{}, {"mean", "", "x"}, {"max", "", "x"}, {"mean", "", "y"}, {"better", "first"}}};
  table.row("after", {"1", "2", "3", "4"});
  EXPECT_THAT(std::move(table).element(),
              HasSubstr("<tr><th rowspan=\"2\"></th><th class=\"group\" colspan=\"2\">x</th>"
                        "<th class=\"group\" colspan=\"1\">y</th><th class=\"first\" "
                        "rowspan=\"2\">better</th></tr>\n<tr><th>mean</th><th>max</th><th>mean</th></tr>\n"));
}

TEST(PageTable, GroupsItsRowsBelowHeadingsOverAllColumns) {
  Table table{"", {{}, {}}};
  table.group("first");
  table.row("a", {"1"});
  table.group("second");
  table.row("b", {"2"});
  const std::string html = std::move(table).element();
  EXPECT_THAT(html, Not(HasSubstr("<thead>")));
  const pugi::xml_document page = parsed(html);
  EXPECT_EQ(page.select_nodes("/table/tbody").size(), 2U);
  EXPECT_EQ(page.select_nodes("/table/tbody/tr[1]/th[@class='rows' and @colspan='2']").size(), 2U);
  EXPECT_EQ(text_of(page.select_node("/table/tbody[2]/tr[2]").node()), "b2");
}

TEST(FactsTable, LeavesOutWhatIsNotKnownAndItselfWhereNothingIs) {
  EXPECT_EQ(text_of(parsed(facts_table("Arm", {{"Robot", "one"}, {"Serial", ""}}))), "ArmRobotone");
  EXPECT_EQ(facts_table("Arm", {{"Serial", ""}}), "");
}

TEST(Page, CarriesStyleSheetAndScriptAsTheyAreInTheirFiles) {
  const std::string folder = std::string(TRUEPOSE_SOURCE_DIR) + "/daemon/report/";
  EXPECT_EQ(page_css(), config::read_bytes(folder + "page.css"));
  EXPECT_EQ(page_js(), config::read_bytes(folder + "page.js"));
  const std::string html = html_page("A & B", "<p>body</p>");
  EXPECT_EQ(text_of(parsed(html).select_node("//title").node()), "A & B");
  EXPECT_THAT(html, HasSubstr(std::string(page_css())));
  EXPECT_THAT(html, HasSubstr(std::string(page_js())));
}

TEST(RawData, IsEncodedInTheLinkItself) {
  const std::string html = raw_data_section({{"<f>.txt", "text/plain",
                                              std::string("\x00\xff"
                                                          "ab",
                                                          4),
                                              "about it"}});
  EXPECT_THAT(html, HasSubstr("href=\"data:text/plain;base64,AP9hYg==\""));
  EXPECT_THAT(html, HasSubstr("download=\"&lt;f&gt;.txt\""));
}

TEST(Axis, HasTheRoundNumbersWithinItsRangeWhicheverWayItRuns) {
  const Axis axis = within(-100, 100, 0, 400, 6, 10);
  EXPECT_THAT(axis.labels(), ElementsAre("\u2212100", "\u221250", "0", "50", "100"));
  EXPECT_EQ(axis.at(0), 200);
  EXPECT_EQ(axis.at(1000), 400);
  EXPECT_TRUE(axis.holds(-109));
  EXPECT_FALSE(axis.holds(111));
  EXPECT_EQ(within(100, -100, 0, 400, 6).at(-100), 400);
  EXPECT_THAT(within(0.31, 0.39, 0, 1, 1).ticks, ElementsAre(0.31, 0.39));
  EXPECT_THAT(covering(log_ticks(0.6, 4, 7), 0, 1, true).labels(), ElementsAre("0.5", "1", "2", "5"));
}

TEST(Plot, EscapesTitlesAndLabels) {
  Plot plot{"<title>", 100, 100};
  plot.rectangle(0, 0, 1, 1, "#000000", "a < b");
  const pugi::xml_document svg = parsed(std::move(plot).finish());
  EXPECT_EQ(text_of(svg.select_node("//text[@class='chart-title']").node()), "<title>");
  EXPECT_EQ(text_of(svg.select_node("//rect/title").node()), "a < b");
}

TEST(Chart, TicksAreRoundNumbersThatCoverTheValues) {
  EXPECT_THAT(nice_ticks(0, 4.465, 5), ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_THAT(nice_ticks(-3.5, 3.2, 5), ElementsAre(-4, -2, 0, 2, 4));
  EXPECT_EQ(nice_ticks(0, 0, 5).front(), 0);
  EXPECT_THAT(log_ticks(0.6, 4, 7), ElementsAre(0.5, 1, 2, 5));
  const std::vector<double> wide = log_ticks(3e-13, 4.5, 7);
  EXPECT_LE(wide.front(), 3e-13);
  EXPECT_GE(wide.back(), 4.5);
  EXPECT_LE(wide.size(), 9u);
}

TEST(Chart, IsDrawnEvenWhereAllValuesAreZeroOrThereIsOnlyOne) {
  for (const bool log_y : {false, true}) {
    PointChart chart{.title = "t",
                     .x_label = "x",
                     .y_unit = "mm",
                     .log_y = log_y,
                     .series = {{"s", "#000000", Marker::Circle, {{1, 0, "p"}}}}};
    const std::string svg = point_chart_svg(chart);
    EXPECT_THAT(svg, Not(HasSubstr("nan")));
    EXPECT_THAT(svg, Not(HasSubstr("inf")));
    parsed(svg);
    parsed(histogram_svg({.title = "h", .x_label = "x", .color = "#000000", .values = {0}}));
  }
}

TEST(ColorScale, RunsFromLightToDarkAndIsLogarithmicOverDecades) {
  const ColorScale narrow{1, 5}, wide{0.01, 1}, flat{1, 1};
  EXPECT_EQ(narrow.color(1), "#f1f6fb");
  EXPECT_EQ(narrow.color(5), "#082a54");
  EXPECT_EQ(narrow.color(99), narrow.color(5));
  EXPECT_FALSE(narrow.logarithmic());
  EXPECT_TRUE(wide.logarithmic());
  EXPECT_EQ(wide.color(0.1), narrow.color(3));  // the middle of either
  EXPECT_EQ(flat.color(1), "#f1f6fb");
}

TEST(Cloud, ShowsTheTrueProportionsFromAbove) {
  const Cloud cloud{.color = "#000000",
                    .arrows = {{{1000, 0, 500}, {0, 1, 0}, "one"}, {{0, 2000, 900}, {1, 0, 0}, "two"}},
                    .tracker_mm = {9000, 0, 0},
                    .exaggeration = 100};
  const pugi::xml_document view = parsed(cloud_svg(cloud, CloudSide::Above, "i"));
  const auto arrows = view.select_nodes("//line[@class='arrow']");
  const auto number = [&](std::size_t arrow, const char* name) {
    return arrows[arrow].node().attribute(name).as_double();
  };
  // x to the right and y up the paper; the second place is 1 m to the left of the first and 2 m up.
  EXPECT_NEAR((number(0, "y1") - number(1, "y1")) / (number(0, "x1") - number(1, "x1")), 2, 0.01);
  // Both arrows are drawn 100 mm long.
  EXPECT_NEAR(number(0, "y1") - number(0, "y2"), number(1, "x2") - number(1, "x1"), 0.2);
  EXPECT_GT(number(0, "y1") - number(0, "y2"), 1);
}

TEST(LocalRegression, FollowsAWaveAndAStraightLineThroughNoiseAndPastAGrossError) {
  constexpr double kRadians = std::numbers::pi / 180;
  Random random{20260512};
  std::vector<std::pair<double, double>> wave, line;
  for (int i = 0; i <= 360; i += 2) {
    wave.emplace_back(i, std::sin(2 * i * kRadians) + 0.2 * random.normal());
    line.emplace_back(i, 0.05 * i - 7 + 0.2 * random.normal());
  }
  wave[50].second = line[100].second = 80;
  for (const auto& [x, y] : local_regression(wave, 12, 60))
    EXPECT_NEAR(y, std::sin(2 * x * kRadians), 0.35) << x;
  for (const auto& [x, y] : local_regression(line, 12, 60)) EXPECT_NEAR(y, 0.05 * x - 7, 0.3) << x;
}

TEST(LocalRegression, HasNoCurveForHardlyAnyPoints) {
  EXPECT_TRUE(local_regression({{1, 1}, {2, 2}}, 1, 10).empty());
  EXPECT_TRUE(local_regression({{1, 1}, {1, 2}, {1, 3}, {1, 4}, {1, 5}}, 1, 10).empty());
}

}  // namespace
}  // namespace truepose::report
