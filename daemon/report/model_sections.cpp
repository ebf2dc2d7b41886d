#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "core/math/angles.hpp"
#include "daemon/report/charts.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/page.hpp"
#include "daemon/report/sections.hpp"
#include "proto/xml/escape.hpp"

namespace truepose::report {
namespace {

/// One row of what each layer bought: the error without and with it, and the part of it that the layer takes
/// away (negative where it adds).
void add_layer(Table& table, std::string_view name, const LayerChoice& layer, std::string_view verdict,
               std::string_view color) {
  const double gain = layer.without_mm > 0 ? 100 * (1 - layer.with_mm / layer.without_mm) : 0;
  const std::string with = layer.standard_error_mm > 0 ? error_text(layer.with_mm, layer.standard_error_mm)
                                                       : error_text(layer.with_mm);
  table.row(xml::escaped(name),
            {std::string(verdict), error_text(layer.without_mm), with, fmt::format("{:.1f} %", gain),
             bar(std::clamp(gain, 0.0, 100.0), color)},
            layer.chosen ? "" : "convention");
}

void add_choice(Table& table, std::string_view name, const LayerChoice& choice) {
  add_layer(table, name, choice, choice.chosen ? "chosen" : "not chosen", kLayersColor);
}

std::string group_title(std::string_view group) {
  if (group == "base") return "Base of the robot in the tracker's frame";
  if (group.starts_with("base"))
    return fmt::format("Base of the robot in the frame of the tracker at station {}", group.substr(4));
  if (group.starts_with("smr."))
    return fmt::format("Reflector {} in the flange frame", xml::escaped(group.substr(4)));
  if (group.starts_with("joint")) return fmt::format("Deviation of joint {}", xml::escaped(group.substr(5)));
  if (group.starts_with("link")) return fmt::format("Link {}", xml::escaped(group.substr(4)));
  return xml::escaped(group);
}

/// What a parameter is shown in, and whether that is turned from rad into deg.
struct Unit {
  std::string_view name;
  bool angle = false;
};

/// Every length is called by one letter (x, a, d); the angles are rx, ry, rz and the Greek ones. A joint's
/// deviation is per unit of what it depends on.
Unit unit_of_parameter(std::string_view leaf) {
  if (leaf.size() == 1) return {"mm"};
  if (leaf == "scale") return {"mm/m"};
  if (leaf.starts_with("shift")) return {"mm"};
  if (leaf == "gravity") return {"deg/kN m", true};
  if (leaf.starts_with("weight")) return {"deg/m", true};
  return {"deg", true};
}

std::string leaf_title(std::string_view leaf) {
  if (leaf == "alpha") return "α";
  if (leaf == "theta") return "θ";
  if (leaf == "beta") return "β";
  if (leaf.starts_with("weight")) return fmt::format("weight at frame {}", xml::escaped(leaf.substr(6)));
  for (const std::string_view motion : {"shift", "turn"}) {
    if (!leaf.starts_with(motion) || leaf.size() <= motion.size()) continue;
    return fmt::format("carriage {} {}, half waves: {}", motion, xml::escaped(leaf.substr(motion.size(), 1)),
                       xml::escaped(leaf.substr(motion.size() + 1)));
  }
  if (!leaf.starts_with("sin") && !leaf.starts_with("cos")) return xml::escaped(leaf);
  const std::string_view order = leaf.substr(3);
  return fmt::format("{} {}q", leaf.substr(0, 3), order == "1" ? "" : xml::escaped(order));
}

/// Whether what is known of a parameter comes from a prior to a part that is worth a column.
bool prior_speaks(const IdentifiedParameter& p) { return p.sigma > 0 && p.data_share < 0.995; }

std::string_view status_of(const IdentifiedParameter& p) {
  if (p.identified) return "identified";
  return prior_speaks(p) ? "shared out by the prior" : "kept, by convention";
}

/// Further columns of the table of parameters, where they are known.
struct ParameterColumns {
  bool prior = false, truth = false;
};

std::vector<std::string> parameter_cells(const IdentifiedParameter& p, std::string_view leaf,
                                         ParameterColumns shown, const ReportDocument& document) {
  const auto [unit, angle] = unit_of_parameter(leaf);
  const auto text = [turned = angle](double value) {
    return turned ? angle_text(value) : length_text(value);
  };
  const bool has_nominal = p.name.starts_with("link");
  std::vector<std::string> cells{
      std::string(unit), has_nominal ? text(p.nominal) : "", text(p.value),
      has_nominal ? text(p.value - p.nominal) : "",
      p.identified || p.sigma > 0 ? sigma_text(angle ? p.sigma * kDegPerRad : p.sigma) : ""};
  if (shown.prior) cells.push_back(p.sigma > 0 ? fmt::format("{:.0f} %", 100 * p.data_share) : "");
  cells.emplace_back(status_of(p));
  if (!shown.truth) return cells;
  const auto truth = document.true_values.find(p.name);
  if (truth == document.true_values.end()) {
    cells.insert(cells.end(), 2, "");
    return cells;
  }
  const double difference = p.value - truth->second;
  cells.push_back(text(truth->second));
  cells.push_back(text(angle ? std::remainder(difference, 2 * std::numbers::pi) : difference));
  return cells;
}

std::string parameter_table(const ReportDocument& document, ParameterColumns shown) {
  std::vector<Column> columns{{}, {"", "text"}, {"nominal"}, {"value"}, {"deviation"}, {"σ"}};
  if (shown.prior) columns.push_back({"data share"});
  columns.push_back({"", "text first"});
  if (shown.truth) columns.insert(columns.end(), {{"true value", "first"}, {"value − true"}});
  Table table{"parameters", std::move(columns)};
  std::string_view group;
  for (const IdentifiedParameter& p : document.parameters) {
    // "smr.1" and "x" of "smr.1.x"
    const std::string_view name = p.name, own = name.substr(0, name.rfind('.'));
    const std::string_view leaf = name.substr(std::min(own.size() + 1, name.size()));
    if (own != group) table.group(group_title(own));
    group = own;
    table.row(leaf_title(leaf), parameter_cells(p, leaf, shown, document), p.identified ? "" : "convention");
  }
  return std::move(table).scrolled();
}

std::vector<std::string> escaped_all(std::vector<std::string> texts) {
  for (std::string& text : texts) text = xml::escaped(text);
  return texts;
}

std::string figures(const ReportDocument& document) {
  Table table{"figures", {{}, {}, {"", "text first meaning"}}};
  table.row("Rank", {fmt::format("{} of {}", document.rank, document.geometric_parameters()),
                     "independent geometric parameters that the positions determine"});
  if (document.rank_gap) {
    table.row("Gap", {fmt::format("{:.2g}", *document.rank_gap),
                      "smallest pivot kept over the largest dropped: how clear-cut the rank is"});
  }
  table.row("Condition", {fmt::format("{:.4g}", document.condition),
                          "largest over smallest singular value, columns at unit norm; below 100 is good"});
  const auto add_index = [&](const char* name, double ObservabilityIndices::*index, const char* meaning) {
    if (const auto& shown = document.observability)
      table.row(name, {fmt::format("{:.3g}", shown->indices.*index), meaning});
  };
  add_index("O1", &ObservabilityIndices::o1,
            "geometric mean of the singular values: volume of the confidence region");
  add_index("O2", &ObservabilityIndices::o2,
            "smallest over largest singular value: roundness of that region");
  add_index("O3", &ObservabilityIndices::o3, "smallest singular value: the worst-known combination");
  add_index("O4", &ObservabilityIndices::o4, "noise amplification: O2 times O3");
  add_index("O5", &ObservabilityIndices::o5, "harmonic sum of the singular values: mean variance");
  return "<h3>How well the poses show the rest</h3>\n" + std::move(table).scrolled() +
         note("O1 to O5 compare sets of poses of the same arm; larger is better.");
}

std::string joint_list(const std::vector<double>& joints, const std::set<int>& left_out) {
  std::string text;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const int number = static_cast<int>(i) + 1;
    if (left_out.contains(number)) continue;
    text += fmt::format("{}{} at {:.0f}", text.empty() ? "" : ", ", number, joints[i]);
  }
  return text;
}

/// The positions of two joints at every pose that identified, each once.
std::vector<std::pair<double, double>> measured(const ReportDocument& document, int x, int y) {
  std::vector<std::pair<double, double>> marks;
  std::set<int> seen;
  const auto joints = static_cast<std::size_t>(std::max(x, y));
  for (const Point& point : document.points_of(PoseSet::Identify)) {
    if (point.joints.size() < joints || !seen.insert(point.pose).second) continue;
    marks.emplace_back(point.joints[static_cast<std::size_t>(x - 1)],
                       point.joints[static_cast<std::size_t>(y - 1)]);
  }
  return marks;
}

/// Standard deviations while two joints sweep and the others are held.
HeatMap heat_map(const record::UncertaintyMap& map, const ReportDocument& document) {
  const auto& [x, y, held, sigma_mm] = map;
  return {.title = fmt::format("Joints {} and {}", x.joint, y.joint),
          .x_label = fmt::format("joint {}", x.joint),
          .y_label = fmt::format("joint {}", y.joint),
          .x_from = x.from,
          .x_to = x.to,
          .y_from = y.from,
          .y_to = y.to,
          .values = sigma_mm,
          .marks = measured(document, x.joint, y.joint),
          .scale = {}};
}

std::string uncertainty_maps(const ReportDocument& document) {
  if (document.prediction_uncertainty->maps.empty()) return "";
  std::vector<HeatMap> maps;
  // One scale for all maps, so that they compare.
  ColorScale scale{std::numeric_limits<double>::infinity(), 0};
  std::string svgs, held;
  for (const record::UncertaintyMap& map : document.prediction_uncertainty->maps) {
    maps.push_back(heat_map(map, document));
    for (const std::vector<double>& row : maps.back().values) {
      scale.lo = std::min(scale.lo, std::ranges::min(row));
      scale.hi = std::max(scale.hi, std::ranges::max(row));
    }
    const int x = map.x.joint, y = map.y.joint;
    if (const std::string others = joint_list(map.held, {x, y}); !others.empty())
      held += fmt::format(" Over joints {} and {} the others are held, joint {}.", x, y, others);
  }
  for (HeatMap& map : maps) {
    map.scale = scale;
    svgs += heat_map_svg(map);
  }
  return charts(svgs) + note(fmt::format("The joints sweep their limits, one turn at most.{} Circles are the "
                                         "poses that identified the arm, with their other joints elsewhere.",
                                         held));
}

}  // namespace

std::string layer_section(const ReportDocument& document) {
  if (!document.non_geometric && !document.field) return "";
  Table table{"layers", {{}, {"", "text"}, {"without", "first"}, {"with"}, {"gain", "first"}, {"", "gain"}}};
  const StageErrors& judged = document.judged();
  table.group(fmt::format("Geometry, on the {} points", document.judging_name()));
  add_layer(table, "links of the arm",
            {.name = {}, .chosen = true, .without_mm = judged.before.rms, .with_mm = judged.geometric.rms},
            "fitted", kGeometricColor);
  if (const auto& deviation = document.non_geometric) {
    table.group("Deviations of the joints, cross-validated");
    add_layer(
        table, "all chosen together",
        {.name = {}, .chosen = true, .without_mm = deviation->geometric_rms_mm, .with_mm = deviation->rms_mm},
        "", kLayersColor);
    for (const LayerChoice& group : document.deviation_layers)
      add_choice(table, group_text(group.name), group);
  }
  if (const auto& field = document.field) {
    table.group("Field of the residuals, cross-validated");
    add_choice(table, "Gaussian process",
               {.name = {},
                .chosen = field->chosen,
                .without_mm = field->rms_zero,
                .with_mm = field->tried.rms,
                .standard_error_mm = field->tried.standard_error});
  }
  return section(
      "What each layer bought",
      note("RMS of the 3-D error (mm) without and with each part of the model, everything else as chosen. "
           "Cross-validated: at poses of the identification that the fit had not seen. A part is chosen only "
           "where its gain is beyond what chance gives.") +
          std::move(table).scrolled());
}

std::string parameters_section(const ReportDocument& document) {
  if (document.parameters.empty()) return "";
  const ParameterColumns shown{.prior = std::ranges::any_of(document.parameters, prior_speaks),
                               .truth = document.truth.has_value()};
  std::string notes = note(fmt::format(
      "The measured positions determine {} of {} geometric parameters. {}: what they would do, identified ones "
      "do in their place, and the predictions are the same. σ is one standard deviation.",
      document.rank, document.geometric_parameters(),
      document.prior ? "The others are shared out by the prior"
                     : "The others are kept at the data sheet's value by convention"));
  if (shown.prior) {
    notes += note(
        "Where the data share is below 100 %, what is known of the parameter comes in part from the prior "
        "that deviations are small.");
  }
  if (shown.truth) {
    notes += note(
        "This arm is simulated: the last column has its true values. A single value may well differ from the "
        "truth by more than its σ: only combinations of parameters that the positions determine can be "
        "compared. The fair comparison is of predictions, that is the validation error above.");
  }
  return section("Identified parameters", notes + parameter_table(document, shown));
}

std::string unknown_section(const ReportDocument& document) {
  const std::string prior = prior_text(document);
  const auto& observability = document.observability;
  if (!observability && prior.empty()) return "";
  return section("Not identifiable from the data",
                 (observability ? sentence_list("Not identifiable, with any tracker",
                                                escaped_all(observability->not_identifiable)) +
                                      sentence_list("Seen, but known less well than from the data sheet",
                                                    escaped_all(observability->weakly_identifiable))
                                : "") +
                     (prior.empty() ? "" : fmt::format("<h3>Prior</h3>\n<p>{}</p>\n", xml::escaped(prior))) +
                     figures(document));
}

std::string transfer_section(const ReportDocument& document) {
  if (!document.prediction_uncertainty) return "";
  const record::Transfer& transfer = *document.prediction_uncertainty;
  std::string html = fmt::format("<p>{} It is worst with joint {} (deg, mm for a prismatic joint).</p>\n",
                                 transfer_text(transfer), joint_list(transfer.worst_joints, {}));
  if (!transfer.warning.empty())
    html += fmt::format("<p class=\"caution\">{}</p>\n", xml::escaped(transfer.warning));
  html += note(
      "What the noise of the measurements leaves open of the parameters, carried to the position of the first "
      "reflector in the tracker's frame. What the model cannot describe is not in it: the validation shows "
      "that.");
  return section("How well unmeasured poses are known", html + uncertainty_maps(document), "whole");
}

}  // namespace truepose::report
