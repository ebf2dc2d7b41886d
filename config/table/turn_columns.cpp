#include "config/table/turn_columns.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "config/number_text.hpp"
#include "core/formatted.hpp"
#include "core/math/angles.hpp"
#include "core/math/units.hpp"

namespace truepose::config {

TurnColumns::TurnColumns(const CsvTable& table) : table_(table) {
  if (std::ranges::none_of(kTurnColumns, [&](std::string_view name) { return table.has(name); })) return;
  if (!table.has("sigma_abc"))
    table.fail(
        "a, b, c are the orientation of a 6-D target, and its standard deviation is missing. Add the column "
        "sigma_abc (deg), or remove a, b, c");
  for (const std::string_view name : kTurnColumns) columns_.push_back(table.column(name));
}

std::optional<MeasuredOrientation> TurnColumns::at(std::size_t row) const {
  constexpr double kGreatestAngle_deg = 360, kGreatestSigma_deg = 10;
  if (std::ranges::all_of(columns_, [&](std::size_t column) { return table_.text(row, column).empty(); }))
    return std::nullopt;
  const auto refuse = [&](std::size_t column, const std::string& expected) {
    table_.fail(row, column, "expected " + expected + " deg, found " + std::string(table_.text(row, column)));
  };
  Eigen::Vector3d abc_deg;
  for (std::size_t k = 0; k < 3; ++k) {
    const double angle = abc_deg[static_cast<Eigen::Index>(k)] = table_.number(row, columns_[k]);
    if (!(std::abs(angle) <= kGreatestAngle_deg))
      refuse(columns_[k], formatted("-%g to %g", kGreatestAngle_deg, kGreatestAngle_deg));
  }
  const double sigma_deg = table_.number(row, columns_[3]);
  if (!(sigma_deg > 0 && sigma_deg <= kGreatestSigma_deg))
    refuse(columns_[3], formatted("more than 0 and at most %g", kGreatestSigma_deg));
  return MeasuredOrientation{pose_from_kuka({0, 0, 0}, abc_deg).linear(), sigma_deg * kRadPerDeg};
}

std::string turn_fields(const std::optional<MeasuredOrientation>& orientation) {
  if (!orientation) return ",,,";
  std::string fields;
  for (const double deg : kuka_abc_deg(orientation->R_WT)) fields += format_number(deg) + ",";
  return fields + format_number(orientation->sigma_rad * kDegPerRad);
}

}  // namespace truepose::config
