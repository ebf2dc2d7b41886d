#include "core/quality/movement_finding.hpp"

#include "core/formatted.hpp"

namespace truepose {
namespace {

using enum FindingKind;

constexpr double kLittle = 1.5;  // times the mean error: what of warmth and slips does no harm

/// "by about 0.21 mm between the points 20 and 21 that were measured"; of several stations, where the points
/// of all are counted, with the place of the latter.
std::string way_of(const Movement& moved, const MeasurementData& data) {
  if (moved.first == 0)
    return formatted("little by little, by about %.2f mm from the first to the last point that was measured",
                     moved.moved_mm);
  const auto place = [&](std::size_t after) {
    const bool of_all = moved.what.kind != ChangeKind::Base && data.station_count() > 1;
    return of_all ? " (" + place_of(data, after) + ")" : "";
  };
  std::string way = formatted("by about %.2f mm between the points %d and %d", moved.moved_mm, moved.before,
                              moved.before + 1) +
                    place(moved.first) + " that were measured";
  if (moved.again > 0)
    way += formatted(", and again between the points %d and %d", moved.before_again, moved.before_again + 1) +
           place(moved.again);
  return way;
}

/// "station 'door': the tracker or the base moved"
std::string in_words(const ChangeHypothesis& change, const CalibratedCell& cell,
                     const MeasurementData& data) {
  const bool of_station = change.what.kind == ChangeKind::Base;
  return (of_station ? station_prefix(data, change.what.index) : "") + name_of(change, cell, data.points);
}

FindingKind kind_of(ChangeKind kind) {
  switch (kind) {
    case ChangeKind::Base:
      return BaseMoved;
    case ChangeKind::JointZero:
      return ZeroChanged;
    case ChangeKind::AllZeros:
      return Mastered;
    case ChangeKind::Load:
      return LoadChanged;
    case ChangeKind::Growth:
      return LengthsChanged;
    default:
      return ReflectorMoved;
  }
}

}  // namespace

std::string place_of(const MeasurementData& data, std::size_t index) {
  const Measurement& point = data.points[index];
  const std::string place = point.row > 0    ? formatted("row %d", point.row)
                            : point.pose > 0 ? formatted("pose %d", point.pose)
                                             : formatted("point %zu", index + 1);
  if (data.station_count() == 1) return place;
  return place + " of '" + data.stations[static_cast<std::size_t>(point.station)] + "'";
}

Finding finding_of(const Movement& moved, const CalibratedCell& cell, const MeasurementData& data,
                   double mean_error_mm) {
  std::string who = in_words(moved, cell, data);
  for (const ChangeHypothesis& other : moved.or_else) who += ", or " + in_words(other, cell, data);
  const bool little = moved.moved_mm < kLittle * mean_error_mm;
  const bool is_open = !moved.or_else.empty() || (moved.or_warmth && !little);
  const std::string how = (is_open ? ", " : " ") + way_of(moved, data);
  if (moved.or_warmth && little)
    return finding(ChangeSmall, who + how + ", or the arm warmed up a little: too little to say which");
  if (moved.or_warmth) who += ", or the arm warmed up";
  const bool surely = !moved.or_warmth && (moved.what.kind == ChangeKind::Base || moved.halves);
  if (!moved.or_joint) return finding(surely ? kind_of(moved.what.kind) : ChangeUnsure, who + how);
  return finding(
      ChangeUnsure,
      who + how + ", or " +
          in_words({{ChangeKind::JointErrors, *moved.or_joint}, TimeProfile::ByAngle}, cell, data) +
          ": the order of the points does not separate these");
}

}  // namespace truepose
