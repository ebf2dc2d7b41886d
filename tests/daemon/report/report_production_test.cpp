// The section of a production program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>
#include <pugixml.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "daemon/report/report.hpp"
#include "daemon/report/sections.hpp"
#include "proto/record/json_io.hpp"
#include "tests/daemon/page.hpp"
#include "tests/daemon/sample_document.hpp"
#include "tests/daemon/sample_path.hpp"

namespace truepose::report {
namespace {

namespace json = boost::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr const char* kSectionOfProgram = "//section[starts-with(h2, 'Production program')]";

json::object document_of(const ProductionPath& path) {
  json::object document = full_document(6);
  document["production"] = record::to_json(record::production_of(path));
  return document;
}

Verdict verdict_on(const ProductionPath& path) {
  return production_verdict(*ReportDocument{document_of(path)}.production);
}

/// The path of the sample with what `change` makes of each of its samples.
ProductionPath changed(const auto& change) {
  ProductionPath path = sample_path();
  for (PathSample& sample : path.samples) change(sample);
  return path;
}

/// The corners of a drawn line, on the paper.
std::vector<Eigen::Vector2d> drawn_line(const pugi::xml_node& line) {
  std::string text = line.attribute("d").value();
  for (char& c : text) c = c == 'M' || c == 'L' ? ' ' : c;
  std::istringstream numbers{text};
  std::vector<Eigen::Vector2d> points;
  for (double x = 0, y = 0; numbers >> x >> y;) points.emplace_back(x, y);
  return points;
}

TEST(ReportProduction, ShowsTheErrorsAtThePointsAndAlongThePathWithTheCorrectionAndWithout) {
  const pugi::xml_document page = parsed(render_html(document_of(sample_path())));
  const pugi::xml_node section = page.select_node(kSectionOfProgram).node();
  EXPECT_EQ(text_of(section.child("h2")), "Production program GLUING");
  std::vector<std::string> rows;
  for (const pugi::xpath_node& row : section.select_nodes(".//table/tbody/tr")) {
    std::string text;
    for (const pugi::xml_node& cell : row.node().children()) text += text_of(cell) + "|";
    rows.push_back(text);
  }
  EXPECT_THAT(rows, ElementsAre("At the points: 2|", "Without the correction|1.500|2.000|2.000||",
                                "With the correction|0.150|0.200|0.200|10|", "Along the path: 121 samples|",
                                "Without the correction|1.500|1.500|1.500||",
                                "With the correction|0.050|0.050|0.050|30|"));
  EXPECT_EQ(
      text_of(section.select_node("p[@class='verdict use']").node()),
      "At 2 points of GLUING the reflector was on average 0.150 mm from where it was wanted, and 1.500 mm "
      "without the correction: 10 times nearer.");
}

/// The sample's arm with drives that take it 1 mm above the wanted path.
ProductionPath lagging_path() {
  ProductionPath path = changed([](PathSample& sample) {
    sample.lagged_mm = sample.wanted_mm;
    if (sample.at_point) return;
    sample.lagged_mm->z() += 1;
    sample.with_mm.z() += 1;
  });
  path.lag =
      DriveLag{.axes = {{0.012, 0.04, true}, {0.012, 0.04, true}, {0.01, 0.03, false}}, .residual_rad = 1e-5};
  return path;
}

TEST(ReportProduction, SetsTheLagOfTheDrivesApart) {
  const json::object document = document_of(lagging_path());
  EXPECT_NEAR(document.at("production").at_pointer("/path/with/max").as_double(), 1.05, 1e-9);
  EXPECT_NEAR(document.at("production").at_pointer("/path_lagged/max").as_double(), 0.05, 1e-9);
  EXPECT_EQ(document.at("production").at_pointer("/lag/axes/1/time_constant_s"), 0.04);
  const std::string said =
      "Distance from the wanted path: mean 1.050, 95 % within 1.050, max 1.050 mm. From the wanted path with the "
      "lag of the drives applied: mean 0.050, 95 % within 0.050, max 0.050 mm. Lag of the drives: 52 ms on average "
      "(A1, A2: dead time 12 ms, time constant 40 ms; A3: moved too little, taken as the mean of the other axes).";
  EXPECT_THAT(render_text(document), HasSubstr("\n" + said + "\n"));
  const std::string html = render_html(document);
  EXPECT_THAT(html, HasSubstr(said));
  const pugi::xml_document page = parsed(html);
  std::vector<std::string> rows;
  for (const pugi::xpath_node& row :
       page.select_node(kSectionOfProgram).node().select_nodes(".//table/tbody/tr[th or td]"))
    rows.push_back(text_of(row.node()));
  EXPECT_EQ(rows.back(), "With the correction, lag of the drives apart0.0500.0500.05030");
}

TEST(ReportProduction, BlamesTheCorrectionForNoLagOfTheDrives) {
  ProductionPath path = lagging_path();
  for (PathSample& sample : path.samples) sample.without_mm.z() -= sample.at_point ? 0 : 0.8;
  EXPECT_EQ(verdict_on(path).kind, Verdict::Kind::Use)
      << "1.05 mm with, and 0.7 without, of which 1 mm is lag";
  path.samples[50].with_mm.z() += 1;
  EXPECT_THAT(verdict_on(path).sentence, HasSubstr("at its worst place along the path"));
}

TEST(ReportProduction, HasNoSectionWhereNoProgramWasRecorded) {
  EXPECT_FALSE(parsed(render_html(full_document(6))).select_node(kSectionOfProgram));
}

TEST(ReportProduction, DrawsTheErrorsAsManyTimesAsLongAsItSays) {
  // In the plane of the path, where they are visible: 1.2 mm along y, off the path along x.
  const ProductionPath path = changed([](PathSample& sample) {
    sample.without_mm = sample.wanted_mm - Eigen::Vector3d{0, 1.2, 0};
  });
  const pugi::xml_document page = parsed(render_html(document_of(path)));
  const pugi::xml_node section = page.select_node(kSectionOfProgram).node();
  // 6 % of the path's diagonal of 447 mm are 22 times 1.2 mm.
  EXPECT_EQ(text_of(section.child("h3")), "The path, errors drawn 20 times as long");
  const pugi::xml_node drawing = section.select_node(".//svg[@aria-label='Without the correction']").node();
  const auto wanted = drawn_line(drawing.select_node("path[@stroke='#8e9aa5']").node()),
             real = drawn_line(drawing.select_node("path[@stroke='#d55e00']").node());
  ASSERT_EQ(wanted.size(), 121U);
  ASSERT_EQ(real.size(), 121U);
  const double mm = (wanted[80] - wanted[0]).norm() / 400;
  EXPECT_NEAR((wanted[120] - wanted[80]).norm() / mm, 200, 1);
  EXPECT_NEAR((real[40] - wanted[40]).norm() / mm, 20 * 1.2, 1);
}

TEST(ReportProduction, LooksAtThePathAtRightAnglesToThePlaneThatHoldsIt) {
  const ProductionPath path = changed([](PathSample& sample) {
    for (Eigen::Vector3d* p : {&sample.wanted_mm, &sample.with_mm, &sample.without_mm})
      *p = Eigen::Vector3d{p->z(), p->x(), p->y()};
  });
  const pugi::xml_document page = parsed(render_html(document_of(path)));
  const pugi::xml_node drawing = page.select_node("//svg[@aria-label='With the correction']").node();
  std::vector<std::string> axes;
  for (const pugi::xpath_node& text : drawing.select_nodes("text[@class='tick'][string-length(.) = 1]"))
    axes.push_back(text_of(text.node()));
  EXPECT_THAT(axes, ElementsAre("y", "z"));
  const auto wanted = drawn_line(drawing.select_node("path[@stroke='#8e9aa5']").node());
  EXPECT_NEAR((wanted[80] - wanted[0]).norm() / (wanted[120] - wanted[80]).norm(), 2, 0.02);
}

TEST(ReportProduction, MarksThePointsByTheirErrorsAndThoseThatAreNotJudged) {
  ProductionPath path = sample_path();
  path.samples.back().gain_percent = 40;
  const pugi::xml_document page = parsed(render_html(document_of(path)));
  std::vector<std::string> labels;
  for (const pugi::xpath_node& label :
       page.select_nodes("//svg[@aria-label='With the correction']/circle/title"))
    labels.push_back(text_of(label.node()));
  EXPECT_THAT(labels, ElementsAre("Point 1: 0.100 mm", "Point 2, while it was ramped: not judged"));
}

TEST(ReportProduction, InterruptsThePathWhereTimeIsMissingOrTheCorrectionWas) {
  ProductionPath path = sample_path();
  for (std::size_t i = 0; i < path.samples.size(); ++i) {
    if (i >= 20 && i < 30) path.samples[i].gain_percent = -1;
    if (i >= 60) path.samples[i].time_s += 3;
  }
  const pugi::xml_document page = parsed(render_html(document_of(path)));
  const pugi::xml_node drawing = page.select_node("//svg[@aria-label='With the correction']").node();
  EXPECT_EQ(drawing.select_nodes("path[@stroke='#8e9aa5']").size(), 2U);
  EXPECT_EQ(drawing.select_nodes("path[@stroke='#00805e']").size(), 3U);
}

TEST(ReportProduction, SaysWhyPointsHadNotAllOfTheCorrection) {
  ProductionPath path = sample_path();
  for (const double gain_percent : {99.0, -1.0, -1.0, -2.0, -3.0}) {
    path.samples.push_back(path.samples.back());
    path.samples.back().wanted_mm.x() += 1;
    path.samples.back().gain_percent = gain_percent;
  }
  const Verdict verdict = verdict_on(path);
  EXPECT_EQ(verdict.kind, Verdict::Kind::Caution);
  EXPECT_THAT(
      verdict.sentence,
      HasSubstr(
          "10 times nearer; 5 of its points were passed without all of the correction: 1 while it was "
          "ramped, 2 with the stream not armed, 1 with no model active, 1 with a fault of the stream."));
  EXPECT_THAT(render_html(document_of(path)), HasSubstr("At the points: 2, and 5 not judged"));
}

TEST(ReportProduction, IsNoGreenerThanWhatWasMeasured) {
  using enum Verdict::Kind;
  EXPECT_EQ(verdict_on(sample_path()).kind, Use);

  ProductionPath one_worse = sample_path();
  one_worse.samples.back().with_mm.z() += 1;
  EXPECT_EQ(verdict_on(one_worse).kind, Caution);
  EXPECT_THAT(verdict_on(one_worse).sentence,
              HasSubstr("1 of the points is farther off with the correction"));

  ProductionPath place_worse = sample_path();
  place_worse.samples[50].with_mm.z() += 1.6;
  EXPECT_EQ(verdict_on(place_worse).kind, Caution);
  EXPECT_THAT(verdict_on(place_worse).sentence, HasSubstr("at its worst place along the path"));

  const ProductionPath path_worse = changed([](PathSample& sample) {
    if (!sample.at_point) sample.with_mm.z() += 2;
  });
  EXPECT_EQ(verdict_on(path_worse).kind, Caution);
  EXPECT_THAT(verdict_on(path_worse).sentence, HasSubstr("along the path the reflector is no nearer"));

  const ProductionPath no_points = changed([](PathSample& sample) { sample.at_point = false; });
  EXPECT_EQ(verdict_on(no_points).kind, Caution);
  EXPECT_THAT(verdict_on(no_points).sentence, HasSubstr("No point is judged."));

  const ProductionPath none = changed([](PathSample& sample) { sample.gain_percent = -2; });
  EXPECT_EQ(verdict_on(none).kind, Caution);
  EXPECT_THAT(verdict_on(none).sentence, HasSubstr("Nothing of GLUING can be judged"));
  EXPECT_FALSE(
      parsed(render_html(document_of(none))).select_node("//svg[@aria-label='With the correction']"));
}

TEST(ReportProduction, RefusesTheModelWhereTheCorrectionBringsTheTcpNoNearer) {
  const json::object document = document_of(changed([](PathSample& sample) { sample.with_mm.z() += 3; }));
  const Verdict verdict = verdict_of(document);
  EXPECT_EQ(verdict.kind, Verdict::Kind::Refuse);
  EXPECT_THAT(verdict.sentence, HasSubstr("Do not correct GLUING by this model"));
  EXPECT_EQ(why_unusable(document), "in production (GLUING) the correction brings the arm no nearer");
  EXPECT_THAT(render_text(document), HasSubstr("\nProduction: Do not correct GLUING"));
  EXPECT_THAT(why_unusable(document_of(sample_path())), IsEmpty());
}

TEST(ReportProduction, ThinsOutAVeryLongPath) {
  ProductionPath path = sample_path();
  const std::vector<PathSample> once = path.samples;
  for (int k = 1; k < 200; ++k) {
    for (PathSample sample : once) {
      sample.time_s += 10 * k;
      path.samples.push_back(sample);
    }
  }
  const pugi::xml_document page = parsed(render_html(document_of(path)));
  const std::string dots =
      page.select_node("//svg[starts-with(@aria-label, 'Distance')]/path[@class='dots']/@d")
          .attribute()
          .value();
  EXPECT_LE(std::ranges::count(dots, 'M'), 2000);
  EXPECT_GT(std::ranges::count(dots, 'M'), 1000);
}

TEST(ReportProduction, TakesAProgramsNameForText) {
  ProductionPath path = sample_path();
  path.program = "<A> & \"B\"";
  const std::string html = render_html(document_of(path));
  EXPECT_EQ(text_of(parsed(html).select_node(kSectionOfProgram).node().child("h2")),
            "Production program <A> & \"B\"");
  EXPECT_THAT(html, Not(HasSubstr("<A>")));
  EXPECT_THAT(downloads_of(html)["production.csv"], HasSubstr("\n0,\"<A> & \"\"B\"\"\",0,100,1000,0,500,"));
}

}  // namespace
}  // namespace truepose::report
