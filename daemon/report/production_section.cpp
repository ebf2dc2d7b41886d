#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "daemon/report/charts.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/page.hpp"
#include "daemon/report/sections.hpp"
#include "proto/rsi/frame_codec.hpp"
#include "proto/xml/escape.hpp"

namespace truepose::report {
namespace {

constexpr std::size_t kMostOfPathDrawn = 2000;
constexpr double kLeastDrawn_mm = 1;  // a path that is shorter has no shape
constexpr double kErrorPart = 0.06;   // of the path's size: as long is the usual error drawn at most

constexpr std::string_view kWithout = "Without the correction", kWith = "With the correction",
                           kLagged = "With the correction, lag of the drives apart";

/// A production program with the error of each sample.
struct JudgedPath {
  const std::vector<PathSample>& samples;
  std::vector<SampleErrors> errors = sample_errors(samples);

  bool is_judged(std::size_t i) const { return samples[i].corrected(); }
};

// ---- What it comes to

/// Why a point was passed without all of the correction.
std::string_view reason_of(double gain_percent) {
  if (gain_percent >= 0) return "while it was ramped";
  if (gain_percent == rsi::kGainNotArmed) return "with the stream not armed";
  if (gain_percent == rsi::kGainNoModel) return "with no model active";
  return "with a fault of the stream";
}

/// "3 of its points were passed without all of the correction: 1 while it was ramped, 2 with no model
/// active"; empty: none.
std::string partly_corrected_text(const record::Production& production) {
  const int count = production.accuracy.points_partly_corrected;
  if (count == 0) return {};
  std::vector<std::pair<std::string_view, int>> reasons;
  for (const PathSample& point : partly_corrected_points(production.path.samples)) {
    const std::string_view reason = reason_of(point.gain_percent);
    auto known = std::ranges::find(reasons, reason, &std::pair<std::string_view, int>::first);
    if (known == reasons.end()) known = reasons.insert(reasons.end(), {reason, 0});
    ++known->second;
  }
  std::string text;
  for (const auto& [reason, times] : reasons)
    text += fmt::format("{} {} {}", text.empty() ? ":" : ",", times, reason);
  return fmt::format("{} of its points {} passed without all of the correction{}", count,
                     count == 1 ? "was" : "were", text);
}

/// "on average 0.052 mm from where it was wanted, and 1.903 mm without the correction: 37 times nearer"
std::string means_text(const ErrorLengths& with, const ErrorLengths& without) {
  const std::string nearer = improves(without.mean, with.mean)
                                 ? fmt::format(": {} times nearer", factor_text(without.mean, with.mean))
                                 : "";
  return fmt::format("on average {} mm from where it was wanted, and {} mm without the correction{}",
                     error_text(with.mean), error_text(without.mean), nearer);
}

/// "At 38 points of GLUING", and along its path where it was judged by no point.
std::string judged_text(const record::Production& production) {
  const PathAccuracy& accuracy = production.accuracy;
  if (!accuracy.points)
    return fmt::format("Along the path of {} the reflector was {}", production.path.program,
                       means_text(accuracy.path_with(), accuracy.path->without));
  return fmt::format("At {} point{} of {} the reflector was {}", accuracy.points->count,
                     accuracy.points->count == 1 ? "" : "s", production.path.program,
                     means_text(accuracy.points->with, accuracy.points->without));
}

/// What the correction made worse though the points are nearer on average; empty: nothing.
std::string worse_text(const record::Production& production) {
  const auto worse = std::ranges::count_if(production.path.samples, [](const PathSample& sample) {
    return sample.at_point && sample.corrected() &&
           (sample.with_mm - sample.wanted_mm).norm() > (sample.without_mm - sample.wanted_mm).norm();
  });
  if (worse > 0)
    return fmt::format("{} of the points {} farther off with the correction than without it", worse,
                       worse == 1 ? "is" : "are");
  if (!production.accuracy.path) return {};
  const ErrorLengths &with = production.accuracy.path_with(), &without = production.accuracy.path->without;
  if (!improves(without.mean, with.mean))
    return "along the path the reflector is no nearer with the correction than without it";
  if (with.max > without.max)
    return "at its worst place along the path the reflector is farther off with the correction than without it";
  return {};
}

// ---- Tables and drawings

/// "12 ms dead time and 40 ms time constant": of each axis, of which those that are alike stand together.
std::string lag_text(const DriveLag& lag) {
  const auto ms = [](double s) { return fmt::format("{:.0f}", 1000 * s); };
  std::vector<std::pair<std::string, std::string>> groups;  // what, of which axes
  for (std::size_t i = 0; i < lag.axes.size(); ++i) {
    const AxisLag& axis = lag.axes[i];
    const std::string what = axis.identified ? fmt::format("dead time {} ms, time constant {} ms",
                                                           ms(axis.dead_time_s), ms(axis.time_constant_s))
                                             : "moved too little, taken as the mean of the other axes";
    auto known = std::ranges::find(groups, what, &std::pair<std::string, std::string>::first);
    if (known == groups.end()) known = groups.insert(groups.end(), {what, ""});
    known->second += fmt::format("{}A{}", known->second.empty() ? "" : ", ", i + 1);
  }
  std::string text;
  for (const auto& [what, axes] : groups)
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", axes, what);
  return text;
}

void add_rows(Table& table, std::string_view title, const ErrorComparison& compared,
              const std::optional<ErrorLengths>& lagged = std::nullopt) {
  table.group(title);
  const auto row = [&](std::string_view name, std::string_view color, const ErrorLengths& errors,
                       const std::string& factor) {
    table.row(fmt::format("{}{}", color_key(color), name),
              {error_text(errors.mean), error_text(errors.p95), error_text(errors.max), factor});
  };
  row(kWithout, kBeforeColor, compared.without, "");
  row(kWith, kCompensatedColor, compared.with, factor_text(compared.without.mean, compared.with.mean));
  if (lagged) row(kLagged, kGeometricColor, *lagged, factor_text(compared.without.mean, lagged->mean));
}

std::string figures_table(const PathAccuracy& accuracy) {
  Table table{"", {{}, {"mean", "strong"}, {"95 % within"}, {"max"}, {"times nearer", "first"}}};
  if (accuracy.points) {
    const int partly = accuracy.points_partly_corrected;
    add_rows(table,
             fmt::format("At the points: {}{}", accuracy.points->count,
                         partly > 0 ? fmt::format(", and {} not judged", partly) : ""),
             *accuracy.points);
  }
  if (accuracy.path)
    add_rows(table, fmt::format("Along the path: {} samples", accuracy.path->count), *accuracy.path,
             accuracy.path_lagged);
  return std::move(table).scrolled();
}

/// Of very many samples of the path every k-th.
std::size_t drawing_step(const std::vector<PathSample>& samples) {
  return (samples.size() + kMostOfPathDrawn - 1) / kMostOfPathDrawn;
}

/// Lines through what `place` makes of the samples of the path that `holds`; a new one where time is missing.
std::vector<PathLine> lines_of(const std::vector<PathSample>& samples, const auto& holds, const auto& place) {
  std::vector<PathLine> lines;
  const PathSample* before = nullptr;
  std::size_t k = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (samples[i].at_point) continue;
    const bool goes = before != nullptr && goes_on(*before, samples[i]);
    before = holds(i) ? &samples[i] : nullptr;
    if (before == nullptr) continue;
    if (!goes) lines.emplace_back();
    if (!goes || k++ % drawing_step(samples) == 0) lines.back().push_back(place(i));
  }
  return lines;
}

std::vector<PathMark> marks_of(const JudgedPath& path, PathError SampleErrors::*stage) {
  std::vector<PathMark> marks;
  int number = 0;
  for (std::size_t i = 0; i < path.samples.size(); ++i) {
    const PathSample& sample = path.samples[i];
    if (!sample.at_point) continue;
    const std::string name = fmt::format("Point {}", ++number);
    const double error_mm = (path.errors[i].*stage).error_mm.norm();
    if (path.is_judged(i)) {
      marks.push_back({sample.wanted_mm, error_mm, fmt::format("{}: {} mm", name, error_text(error_mm))});
    } else {
      marks.push_back({sample.wanted_mm, std::nullopt,
                       fmt::format("{}, {}: not judged", name, reason_of(sample.gain_percent))});
    }
  }
  return marks;
}

/// The diagonal of the box about them.
double extent_mm(const std::vector<PathLine>& lines) {
  if (lines.empty()) return 0;
  Eigen::Vector3d lo = lines.front().front(), hi = lo;
  for (const PathLine& line : lines) {
    for (const Eigen::Vector3d& p : line) {
      lo = lo.cwiseMin(p);
      hi = hi.cwiseMax(p);
    }
  }
  return (hi - lo).norm();
}

double exaggeration_of(const JudgedPath& path, double length_mm) {
  std::vector<double> errors_mm;
  for (std::size_t i = 0; i < path.samples.size(); ++i) {
    if (path.is_judged(i)) errors_mm.push_back(path.errors[i].without.error_mm.norm());
  }
  return report::exaggeration_of(std::move(errors_mm), length_mm);
}

std::string drawings(const JudgedPath& path) {
  const std::vector<PathLine> wanted = lines_of(
      path.samples, [](std::size_t) { return true; },
      [&path](std::size_t i) { return path.samples[i].wanted_mm; });
  const double size_mm = extent_mm(wanted);
  if (size_mm < kLeastDrawn_mm) return "";
  const double factor = exaggeration_of(path, kErrorPart * size_mm);
  const auto drawing = [&](std::string_view name, std::string_view color, PathError SampleErrors::*stage) {
    const auto enlarged = [&](std::size_t i) -> Eigen::Vector3d {
      const PathError& error = path.errors[i].*stage;
      return error.place_mm + factor * error.error_mm;
    };
    return PathDrawing{std::string(name), color, wanted,
                       lines_of(
                           path.samples, [&path](std::size_t i) { return path.is_judged(i); }, enlarged),
                       marks_of(path, stage)};
  };
  return fmt::format("<h3>The path, errors drawn {:g} times as long</h3>\n", factor) +
         note(
             "Grey: the wanted path, seen at right angles to the plane that holds most of it. Coloured: where the "
             "reflector was. Dots: the program's points, dashed ones not judged.") +
         charts(path_drawings_svg(std::array{drawing(kWithout, kBeforeColor, &SampleErrors::without),
                                             drawing(kWith, kCompensatedColor, &SampleErrors::with)}));
}

// Without the correction, with it, and with it from the wanted path with the lag applied.
using PathSeries = std::array<Series, 3>;

PathSeries path_series() {
  return {Series{std::string(kWithout), kBeforeColor, Marker::HollowCircle},
          Series{std::string(kWith), kCompensatedColor, Marker::Circle},
          Series{std::string(kLagged), kGeometricColor, Marker::Circle}};
}

void add(PathSeries& series, double x, const SampleErrors& errors, const std::string& place) {
  const auto add_to = [&](Series& one, const PathError& error) {
    const double mm = error.error_mm.norm();
    one.points.push_back({x, mm, fmt::format("{}, {}: {} mm", one.name, place, error_text(mm))});
  };
  add_to(series[0], errors.without);
  add_to(series[1], errors.with);
  if (errors.with_lagged) add_to(series[2], *errors.with_lagged);
}

std::string chart(std::string title, std::string x_label, PathSeries series) {
  if (series[0].points.empty()) return "";
  std::vector<Series> shown{std::move(series[0]), std::move(series[1])};
  if (!series[2].points.empty()) shown.push_back(std::move(series[2]));
  return boxed(point_chart_svg({.title = std::move(title),
                                .x_label = std::move(x_label),
                                .y_unit = "mm, logarithmic",
                                .log_y = true,
                                .series = std::move(shown)}));
}

std::string path_chart(const JudgedPath& path) {
  PathSeries series = path_series();
  double length_mm = 0;
  const PathSample* before = nullptr;
  std::size_t k = 0;
  for (std::size_t i = 0; i < path.samples.size(); ++i) {
    const PathSample& sample = path.samples[i];
    if (sample.at_point) continue;
    if (before != nullptr && goes_on(*before, sample))
      length_mm += (sample.wanted_mm - before->wanted_mm).norm();
    before = &sample;
    if (path.is_judged(i) && k++ % drawing_step(path.samples) == 0)
      add(series, length_mm, path.errors[i], fmt::format("{:.0f} mm", length_mm));
  }
  return chart("Distance from the wanted path", "length of the path, mm", std::move(series));
}

std::string point_chart(const JudgedPath& path) {
  PathSeries series = path_series();
  int number = 0;
  for (std::size_t i = 0; i < path.samples.size(); ++i) {
    if (!path.samples[i].at_point) continue;
    ++number;
    if (path.is_judged(i)) add(series, number, path.errors[i], fmt::format("point {}", number));
  }
  return chart("Error at the points", "point", std::move(series));
}

/// The distance from the wanted path with and without the lag of the drives, and that lag; empty where no
/// path was judged.
std::string path_text(const record::Production& production) {
  const PathAccuracy& accuracy = production.accuracy;
  if (!accuracy.path) return {};
  const auto figures = [](const ErrorLengths& lengths) {
    return fmt::format("mean {}, 95 % within {}, max {} mm", error_text(lengths.mean),
                       error_text(lengths.p95), error_text(lengths.max));
  };
  std::string text = fmt::format("Distance from the wanted path: {}.", figures(accuracy.path->with));
  if (!accuracy.path_lagged) return text + " It includes what the lag of the drives cuts off curves.";
  text += fmt::format(" From the wanted path with the lag of the drives applied: {}.",
                      figures(*accuracy.path_lagged));
  if (!production.path.lag) return text;
  return text + fmt::format(" Lag of the drives: {:.0f} ms on average ({}).",
                            1000 * production.path.lag->mean_delay_s(), lag_text(*production.path.lag));
}

}  // namespace

Verdict production_verdict(const record::Production& production) {
  using enum Verdict::Kind;
  const PathAccuracy& accuracy = production.accuracy;
  const std::string& program = production.path.program;
  const std::string partly = partly_corrected_text(production), but = partly.empty() ? "" : "; " + partly;
  if (!accuracy.judged())
    return {
        Caution,
        fmt::format(
            "Nothing of {} can be judged: it never ran with all of the correction{}. Arm the stream with a "
            "model active, and run it again.",
            program, but)};
  const std::string judged = judged_text(production) + but;
  if (accuracy.refuted())
    return {Refuse, fmt::format("Do not correct {} by this model: it brings the arm no nearer. {}.", program,
                                judged)};
  if (const std::string worse = worse_text(production); !worse.empty())
    return {Caution, fmt::format("Look first at what became worse: {}. {}.", worse, judged)};
  if (!accuracy.points) return {Caution, judged + ". No point is judged."};
  return {partly.empty() ? Use : Caution, judged + "."};
}

std::string production_text(const record::Production& production) {
  const std::string path = path_text(production);
  return fmt::format("Production: {}\n{}{}", production_verdict(production).sentence, path,
                     path.empty() ? "" : "\n");
}

std::string why_refuted(const record::Production& production) {
  if (!production.accuracy.refuted()) return {};
  return fmt::format("in production ({}) the correction brings the arm no nearer", production.path.program);
}

std::string production_csv(const ProductionPath& path) {
  std::string csv =
      "time_s,program,point,gain_percent,wanted_x_mm,wanted_y_mm,wanted_z_mm,with_x_mm,with_y_mm,with_z_mm,"
      "without_x_mm,without_y_mm,without_z_mm\n";
  for (const PathSample& sample : path.samples) {
    csv += fmt::format("{},{},{:d},{}", sample.time_s, csv_text(path.program), sample.at_point,
                       sample.gain_percent);
    for (const Eigen::Vector3d* p : {&sample.wanted_mm, &sample.with_mm, &sample.without_mm})
      csv += fmt::format(",{},{},{}", p->x(), p->y(), p->z());
    csv += "\n";
  }
  return csv;
}

std::string production_section(const ReportDocument& document) {
  return document.production ? production_section(*document.production) : "";
}

std::string production_section(const record::Production& production) {
  const std::string title = "Production program " + xml::escaped(production.path.program),
                    verdict = verdict_paragraph(production_verdict(production));
  if (!production.accuracy.judged()) return section(title, verdict);
  const JudgedPath path{production.path.samples};
  return section(
      title,
      verdict +
          note(
              "At the points: from where the data sheet's arm would have the reflector. Along the path: from its nearest place. "
              "The drives' lag in time is then no error, but the curves that they cut off are. Only where all of "
              "the correction was in effect; without it: the same arm, its axes at the set points, so nothing cut off. "
              "In mm, the robot's base frame.") +
          note(path_text(production)) + figures_table(production.accuracy) + drawings(path) +
          charts(path_chart(path) + point_chart(path)),
      "whole");
}

}  // namespace truepose::report
