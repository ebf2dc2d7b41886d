#include "core/quality/commanded_poses.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <utility>

#include "core/data/error_bounds.hpp"
#include "core/data/other_units.hpp"
#include "core/formatted.hpp"

namespace truepose {
namespace {

/// Of the mean attained position from the commanded one.
double distance_mm(const TestPoint& point) {
  std::vector<TestPose> attained;
  for (const AttainedPose& pose : point.attained) attained.push_back({.p_mm = pose.pose.p_mm});
  return (mean_pose(attained).p_mm - point.commanded.p_mm).norm();
}

const TestPoint& farthest(const std::vector<TestPoint>& points) {
  return *std::ranges::max_element(points, {}, distance_mm);
}

/// What may be wrong with all positions of a file, and how it is undone.
struct FileMistake {
  std::string wrong, remedy;
  std::function<void(TestPoint&)> apply_fix;
};

void add_units(std::vector<FileMistake>& mistakes) {
  for (const auto& [unit, mm] : kOtherUnits) {
    const std::string in_unit = std::string(" are in ") + unit + ", not mm";
    mistakes.push_back({"the measured positions" + in_unit, "them converted", [mm](TestPoint& point) {
                          for (AttainedPose& attained : point.attained) attained.pose.p_mm *= mm;
                        }});
    mistakes.push_back({"the commanded positions" + in_unit, "them converted",
                        [mm](TestPoint& point) { point.commanded.p_mm *= mm; }});
  }
}

void add_columns(std::vector<FileMistake>& mistakes) {
  std::array order{0, 1, 2};
  while (std::ranges::next_permutation(order).found) {
    std::string columns;
    for (const int axis : order) columns += std::string(columns.empty() ? "" : ",") + "xyz"[axis];
    mistakes.push_back({"the columns of the measured or the commanded positions are swapped",
                        "x,y,z measured taken from " + columns, [order](TestPoint& point) {
                          for (AttainedPose& attained : point.attained)
                            attained.pose.p_mm = Eigen::Vector3d(attained.pose.p_mm(order));
                        }});
  }
}

}  // namespace

std::optional<std::string> not_as_commanded(const std::vector<TestPoint>& points,
                                            const IntoCommandedFrame& into_frame) {
  const auto given = into_frame(points);
  if (!given) return given.error();
  const TestPoint& far = farthest(*given);
  if (distance_mm(far) <= kMaxArmError_mm) return std::nullopt;
  std::vector<FileMistake> mistakes;
  add_units(mistakes);
  add_columns(mistakes);
  for (const FileMistake& mistake : mistakes) {
    std::vector<TestPoint> fixed = points;
    std::ranges::for_each(fixed, mistake.apply_fix);
    const auto in_frame = into_frame(std::move(fixed));
    if (!in_frame || distance_mm(farthest(*in_frame)) > kMaxArmError_mm) continue;
    return mistake.wrong + ": with " + mistake.remedy +
           formatted(" the largest distance from a commanded position falls from %.4g to %.3g mm",
                     distance_mm(far), distance_mm(farthest(*in_frame)));
  }
  return far.name +
         formatted(
             " was attained %.4g mm from where it was commanded, which no arm is wrong by: check the "
             "names of the points and in which frame both stand",
             distance_mm(far));
}

}  // namespace truepose
