#include "tools/truepose/iso9283_text.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/math/angles.hpp"

namespace truepose::tools {
namespace {

std::string frame_text(record::Iso9283Frame frame) {
  switch (frame) {
    case record::Iso9283Frame::AsGiven:
      return "Measured poses were taken as given, in the frame of the commanded ones.\n";
    case record::Iso9283Frame::Model:
      return "Measured poses were brought into the robot's base by the model's base pose.\n";
    case record::Iso9283Frame::Fitted:
      return "The measuring frame was fitted to the commanded positions: AP is relative to that fit, and the "
             "absolute one is greater.\n";
  }
  return {};
}

/// "P1", "P1 +x", "P1 +x 60 min"
std::string label(const TestPoint& point, const std::string& direction, const std::string& series) {
  return point.name + (direction.empty() ? "" : " " + direction) + (series.empty() ? "" : " " + series);
}

std::string angles(const std::optional<Eigen::Vector3d>& abc_rad) {
  if (!abc_rad) return {};
  const Eigen::Vector3d deg = *abc_rad * kDegPerRad;
  return fmt::format(" {:9.4f} {:9.4f} {:9.4f}", deg.x(), deg.y(), deg.z());
}

std::string characteristics_table(const Iso9283Result& result, std::span<const TestPoint> points) {
  const bool oriented = std::ranges::any_of(
      result.sets, [](const CycleSet& s) { return s.characteristics.repeatability.abc_rad.has_value(); });
  std::size_t width = 14;
  for (const CycleSet& set : result.sets)
    width = std::max(width, label(points[set.point], set.direction, set.series).size() + 1);
  std::string text = fmt::format("{:<{}}{:>7} {:>9} {:>9} {:>9} {:>9} {:>9}", "mm, deg", width, "cycles",
                                 "AP_p", "AP_x", "AP_y", "AP_z", "RP_l");
  if (oriented)
    text +=
        fmt::format(" {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}", "AP_a", "AP_b", "AP_c", "RP_a", "RP_b", "RP_c");
  text += '\n';
  double worst_ap = 0, worst_rp = 0;
  for (const CycleSet& set : result.sets) {
    const auto& [ap, rp] = set.characteristics;
    text += fmt::format("{:<{}}{:>7} {:9.4f} {:9.4f} {:9.4f} {:9.4f} {:9.4f}{}{}\n",
                        label(points[set.point], set.direction, set.series), width, set.cycles, ap.p_mm,
                        ap.xyz_mm.x(), ap.xyz_mm.y(), ap.xyz_mm.z(), rp.l_mm, angles(ap.abc_rad),
                        angles(rp.abc_rad));
    worst_ap = std::max(worst_ap, ap.p_mm);
    worst_rp = std::max(worst_rp, rp.l_mm);
  }
  return text +
         fmt::format("{:<{}}{:>7} {:9.4f} {:29} {:9.4f}\n", "worst", width, "", worst_ap, "", worst_rp);
}

}  // namespace

std::string iso9283_text(const Iso9283Result& result, std::span<const TestPoint> points,
                         record::Iso9283Frame frame) {
  std::string text = "ISO 9283:1998. " + frame_text(frame);
  if (result.fewest_cycles < kIso9283Cycles) {
    text +=
        fmt::format("The standard asks for {} cycles, and some poses have {}: these figures do not comply.\n",
                    kIso9283Cycles, result.fewest_cycles);
  }
  text += "\n" + characteristics_table(result, points);
  for (const PointVariation& v : result.variations) {
    text += fmt::format("\n{}: vAP_p {:.4f} mm over {} directions{}\n", label(points[v.point], "", v.series),
                        v.variation.p_mm, v.directions.size(),
                        v.variation.abc_rad ? ", vAP_a, b, c" + angles(v.variation.abc_rad) + " deg" : "");
  }
  for (const PointDrift& d : result.drifts) {
    text += fmt::format(
        "\n{}: dAP_p {:.4f}, dRP_l {:.4f} mm from {} to {}; the mean position moved by {:.4f} mm\n",
        label(points[d.point], d.direction, ""), d.drift.ap_p_mm, d.drift.rp_l_mm, d.series.front(),
        d.series.back(), d.drift.moved_mm);
  }
  return text;
}

}  // namespace truepose::tools
