#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>

#include "core/math/angles.hpp"
#include "core/math/units.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/report.hpp"
#include "daemon/report/sections.hpp"
#include "proto/text/message.hpp"

namespace truepose::report {
namespace {

std::string title_of(const Stage& stage) {
  std::string title(stage.name);
  title[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(title[0])));
  return title;
}

std::string cell(const Figure& figure, const Stage& stage) {
  const double mm = figure.of(*stage.errors);
  if (!stage.spread) return fmt::format("{:>13}", error_text(mm));
  if (figure.spread) return fmt::format("{:>18}", error_text(mm, stage.spread->*figure.spread));
  return fmt::format("{:>10}        ", error_text(mm));  // as wide as with " ± 0.003"
}

std::string table(std::string_view title, const std::vector<Stage>& stages) {
  std::string text = fmt::format("{}\n  {:<10}", title, "mm");
  for (const Stage& stage : stages) text += fmt::format("{:>{}}", title_of(stage), stage.spread ? 18 : 13);
  text += "\n";
  for (const Figure& figure : kFigures) {
    if (figure.name == "std") continue;
    std::string line = fmt::format("  {:<10}", figure.name);
    for (const Stage& stage : stages) line += cell(figure, stage);
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string tables(const ReportDocument& document) {
  const auto counts = [](std::string_view set, const StageErrors& stages) {
    return fmt::format("{}: {} poses, {} points", set, stages.poses, stages.points);
  };
  std::string text =
      table(counts("Identification", document.identify), stages_of(document, PoseSet::Identify));
  if (!document.validate) return text;
  std::string title = counts("Validation", *document.validate);
  if (const std::string runs = validation_text(document); !runs.empty()) title += ", " + runs;
  return text + "\n" + table(title, stages_of(document, PoseSet::Validate));
}

std::string station_errors_text(const StageErrors& errors) {
  return fmt::format("{} poses, mean error {} mm -> {} mm", errors.poses, error_text(errors.before.mean),
                     error_text(errors.after.mean));
}

std::string station_lines(const std::vector<record::Station>& stations) {
  if (stations.empty()) return {};
  std::string text = "\nStations (the base of a model file is the one that the first of them sees):\n";
  for (const record::Station& station : stations)
    text += fmt::format("  {}: {}\n", station.name, station_text(station));
  return text;
}

std::string deviation_lines(const ReportDocument& document) {
  std::string groups;
  for (const LayerChoice& group : document.deviation_layers) {
    if (!group.chosen) continue;
    groups += fmt::format("  without {:<22}{:>8} mm, {:.1f} % more\n", group_text(group.name),
                          error_text(group.without_mm), 100 * (group.without_mm / group.with_mm - 1));
  }
  if (groups.empty()) return "\nNon-geometric errors: none predicts unseen poses better.\n";
  return fmt::format("\nNon-geometric errors: cross-validated RMS {} mm -> {} mm\n",
                     error_text(document.non_geometric->geometric_rms_mm),
                     error_text(document.non_geometric->rms_mm)) +
         groups;
}

std::string field_lines(const FieldChoice& field) {
  if (!field.chosen) return "\nResidual field: unseen poses are predicted as well without it.\n";
  return fmt::format("\nResidual field: Gaussian process, cross-validated RMS {} mm -> {} mm\n",
                     error_text(field.rms_zero), error_text(field.tried.rms, field.tried.standard_error));
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

std::string thermal_lines(const record::Thermal& thermal) {
  if (!thermal.chosen) return "\nWarmth: the arm is predicted as well without it.\n";
  std::string at =
      fmt::format("lengths by {:.1f} ppm per kelvin; the model is that of drives at {:.1f} C on average",
                  thermal.expansion_ppm_per_k, mean_of(thermal.reference_c));
  const double reached = mean_of(thermal.reference_c);
  const std::string arm = reached < 1
                              ? fmt::format("the arm at the last point, {:.0f} % of the way", 100 * reached)
                              : "the warm arm";
  if (thermal.time_constant_s > 0)
    at = fmt::format("in {:.0f} min; the model is that of {}", thermal.time_constant_s / 60, arm);
  if (thermal.time_constant_poses > 0)
    at = fmt::format("in {:.0f} poses, by the order of the rows; the model is that of {}",
                     thermal.time_constant_poses, arm);
  return fmt::format("\nWarmth moves joint zeros and lengths, {}: cross-validated RMS {} mm -> {} mm\n", at,
                     error_text(thermal.without_rms_mm), error_text(thermal.rms_mm));
}

std::string far_lines(std::string_view title, std::vector<record::Rejected> points) {
  constexpr std::size_t kListed = 10;
  if (points.empty()) return {};
  std::ranges::stable_sort(points, std::ranges::greater{}, &record::Rejected::sigmas);
  std::string text =
      fmt::format("\n{}: {}{}\n", title, points.size(),
                  points.size() > kListed ? fmt::format(", the worst {} of them", kListed) : "");
  points.resize(std::min(points.size(), kListed));
  for (const record::Rejected& point : points) {
    text += fmt::format("  {}: {}, {:.0f} standard deviations\n", place_text(point), distance_text(point),
                        point.sigmas);
  }
  return text;
}

std::string sentence_lines(std::string_view title, const std::vector<std::string>& sentences) {
  if (sentences.empty()) return {};
  std::string text = fmt::format("\n{}:\n", title);
  for (const std::string& sentence : sentences) text += "  " + sentence + "\n";
  return text;
}

/// What 6-D targets show of orientations.
std::string turn_lines(const ReportDocument& document) {
  std::string text;
  for (const PoseSet set : {PoseSet::Identify, PoseSet::Validate}) {
    if (set == PoseSet::Validate && !document.validate) continue;
    if (const auto& turns = document.errors_of(set).orientation_errors)
      text += fmt::format("{} of 6-D targets, {}: {}\n",
                          text.empty() ? "\nOrientation error" : "Orientation error",
                          set == PoseSet::Validate ? "validation" : "identification", turns_text(*turns));
  }
  for (const record::MountedTarget& target : document.targets) text += mounting_text(target) + "\n";
  return text;
}

/// Findings in addition to errors and parameters, each part after an empty line.
std::string findings(const ReportDocument& document) {
  std::string text = turn_lines(document) + station_lines(document.stations);
  if (document.non_geometric) text += deviation_lines(document);
  if (document.field) text += field_lines(*document.field);
  if (document.thermal) text += thermal_lines(*document.thermal);
  text += far_lines("Points to identify that were left out", document.rejected) +
          far_lines("Validation points beyond six sigma", document.validation_outliers);
  if (const auto& observability = document.observability) {
    text += sentence_lines("Not identifiable from these poses", observability->not_identifiable) +
            sentence_lines("What the data sheet knows better", observability->weakly_identifiable);
  }
  if (const std::string prior = prior_text(document); !prior.empty()) text += "\n" + prior + "\n";
  if (document.prediction_uncertainty) {
    text += fmt::format("\n{}\n", transfer_text(*document.prediction_uncertainty));
    if (!document.prediction_uncertainty->warning.empty())
      text += fmt::format("Warning: {}\n", document.prediction_uncertainty->warning);
  }
  if (document.production) text += "\n" + production_text(*document.production);
  return text;
}

std::string verdict_lines(const ReportDocument& document) {
  std::string text =
      fmt::format("\nVerdict: {}. {}.\n", name_of(kVerdictColorNames, document.verdict->color()),
                  verdict_heading(document));
  AnswerText answer;
  for (const Finding& found : document.verdict->findings)
    text += fmt::format("  {}: {}\n", name_of(kSeverityNames, found.severity),
                        answer.add({found.code, found.sentence, found.what_to_do}));
  return text;
}

}  // namespace

std::string render_text(const ReportDocument& document) {
  std::string text = tables(document);
  text += fmt::format("\nMean position error {} mm -> {} mm, {}. {} of {} geometric parameters determined.\n",
                      error_text(document.judged().before.mean), error_text(document.achieved().mean),
                      improvement_text(document), document.rank, document.geometric_parameters());
  return text + findings(document) + verdict_lines(document);
}

std::string why_unusable(const ReportDocument& document) {
  if (document.verdict->failed()) {
    const Finding& gravest = document.verdict->findings.front();
    return sentences({gravest.code, gravest.sentence, gravest.what_to_do});
  }
  return document.production ? why_refuted(*document.production) : "";
}

std::string improvement_text(const ReportDocument& document) {
  if (!document.improved()) return "no improvement";
  return factor_text(document.judged().before.mean, document.achieved().mean) + " times more accurate";
}

std::string group_text(std::string_view name) {
  const std::size_t dot = name.find('.');
  if (dot == std::string_view::npos || !name.starts_with("joint")) return std::string(name);
  const std::string_view joint = name.substr(5, dot - 5), kind = name.substr(dot + 1);
  if (kind.starts_with("harmonic")) return fmt::format("joint {}, harmonic {}", joint, kind.substr(8));
  return fmt::format("joint {}, {}", joint, kind);
}

std::string validation_text(const ReportDocument& document) {
  if (!document.spread) return {};
  if (!document.cross_validated())
    return fmt::format("mean ± standard deviation over {} splits", document.spread->count);
  return fmt::format(
      "each pose predicted by the one of {} fits that had not seen it (± standard deviation over the folds)",
      document.spread->count);
}

std::string prior_text(const ReportDocument& document) {
  if (!document.prior) return {};
  double from_prior = 0;
  int links = 0, mostly = 0;
  for (const IdentifiedParameter& p : document.parameters) {
    if (!p.name.starts_with("link")) continue;
    ++links;
    from_prior += 1 - p.data_share;
    mostly += p.data_share < 0.5;
  }
  std::string text = fmt::format(
      "The poses do not show all link errors well. These were taken as small before they were measured: {} mm, {} deg, "
      "one standard deviation.",
      sigma_text(document.prior->scale.length_mm), sigma_text(document.prior->scale.angle_rad * kDegPerRad));
  if (links > 0) {
    text += fmt::format(
        " This prior makes up {:.0f} % of what is known of them, and more than half of it for {} of {} link "
        "parameters.",
        100 * from_prior / links, mostly, links);
  }
  return text;
}

std::string distance_text(const record::Rejected& point) {
  if (point.orientation_error_rad > 0)
    return fmt::format("turned by {:.3f} deg", point.orientation_error_rad * kDegPerRad);
  return error_text(point.residual_mm) + " mm";
}

std::string turns_text(const TurnErrors& turns) {
  const auto deg = [](double rad) { return fmt::format("{:.4f}", rad * kDegPerRad); };
  return fmt::format("mean {} -> {} deg, max {} -> {} deg, {:.0f} readings", deg(turns.before.mean_rad),
                     deg(turns.after.mean_rad), deg(turns.before.max_rad), deg(turns.after.max_rad),
                     static_cast<double>(turns.readings));
}

std::string mounting_text(const record::MountedTarget& target) {
  const Eigen::Vector3d deg = target.rxyz_rad * kDegPerRad;
  return fmt::format("Target {} on the flange: A {:.4f}, B {:.4f}, C {:.4f} deg, sigma {:.4f} deg",
                     target.smr, deg.z(), deg.y(), deg.x(), target.sigma_rad * kDegPerRad);
}

std::string place_text(const record::Rejected& point) {
  std::string place;
  const auto add = [&place](std::string_view part, const std::string& which) {
    place += fmt::format("{}{} {}", place.empty() ? "" : ", ", part, which);
  };
  if (!point.station.empty()) add("station", point.station);
  if (point.pose > 0) add("pose", std::to_string(point.pose));
  if (!point.smr.empty()) add("reflector", point.smr);
  if (point.row > 0) add("row", std::to_string(point.row));
  return place;
}

std::string station_text(const record::Station& station) {
  std::string text = station_errors_text(station.identify);
  if (station.validate) text += fmt::format("; validation {}", station_errors_text(*station.validate));
  return text;
}

std::string transfer_text(const record::Transfer& transfer) {
  return fmt::format(
      "The position of an unmeasured pose is predicted with a standard deviation of {} mm (RMS over the joint "
      "limits), {} mm at worst.",
      sigma_text(transfer.rms_mm), sigma_text(transfer.max_mm));
}

}  // namespace truepose::report
