#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/cell_config.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/plan/scene.hpp"
#include "daemon/campaign/cell_devices.hpp"
#include "daemon/store/store.hpp"

namespace truepose::daemon {

/// Which of a cell's reflectors are measured.
enum class Reflectors {
  First,
  All,  ///< that the tracker sees at a pose
};

/// Where the reflectors on the flange are looked for, and how they are measured at a pose.
class ReflectorSearch {
 public:
  /// What is referred to outlives it.
  ReflectorSearch(const config::CellConfig& config, CellDevices& devices);

  void look_for(Reflectors reflectors);
  /// From now on a reflector sits where the cell has this one, and nowhere else.
  void look_for_single(std::size_t reflector) { one_ = reflector; }
  /// Whether a reflector sits there at all.
  bool is_there(std::string_view name) const { return !one_ || names_[*one_] == name; }
  /// Says where they are to be looked for from now on.
  /// @param reach  by which the configured search radius and gate are multiplied
  void expect(CalibratedCell cell, double reach = 1);
  /// Says that the tracker no longer stands where `expect` has it, or not as the cell file says.
  /// @param X_now_first  pose of its frame of then in the one of now
  void set_tracker_shift(const Eigen::Isometry3d& X_now_first);
  /// A circle around a reflector in which there is no other, as large as the first search at most, mm.
  double clear_radius_mm() const;
  const CalibratedCell& expected() const { return expected_; }
  /// Whether base and reflectors are known better than the cell file says.
  bool placement_known() const { return placement_known_; }
  /// Where that point was to be expected, mm, tracker frame of then.
  Eigen::Vector3d predicted_mm(const StoredPoint& point) const;
  const std::string& name(std::size_t reflector) const { return names_[reflector]; }
  /// The names of those that are looked for there: "1, 2".
  std::string names_at(const JointVector& q, PointPurpose purpose);

  /// The arm standing somewhere.
  struct ArmPosture {
    JointVector q;
    std::vector<std::int8_t> direction;
    PointPurpose purpose = PointPurpose::Identify;
    int readings = 1;
    bool two_face = false;
  };
  struct ReflectorResult {
    std::size_t reflector = 0;  ///< its place in the cell file
    CellDevices::MeasureResult measured;
  };
  struct SearchResult {
    std::vector<ReflectorResult> found;  ///< at least one
    std::vector<std::string> missed;     ///< which others were not measured and why, a sentence each
  };
  CellDevices::Outcome<SearchResult> measure(ArmPosture posture);

 private:
  using Places = std::vector<Eigen::Vector3d>;

  std::vector<std::size_t> reflectors_at(const JointVector& q, PointPurpose purpose);
  /// @param radius_mm  while the placement is not known
  CellDevices::Outcome<CellDevices::MeasureResult> look_at(const ArmPosture& posture,
                                                           const Eigen::Vector3d& p_W_mm, double radius_mm);
  CellDevices::Outcome<SearchResult> measure_each(ArmPosture posture, std::vector<std::size_t> reflectors);
  CellDevices::Outcome<SearchResult> identify_by_shape(ArmPosture posture,
                                                       std::vector<std::size_t> reflectors);
  CellDevices::Outcome<SearchResult> confirm_expected(ArmPosture posture, std::size_t expected);
  CellDevices::Outcome<SearchResult> measure_as_if_first(ArmPosture posture, Places places_mm,
                                                         std::size_t which, CellDevices::MeasureResult first);
  void prepare_visibility();
  /// mm, tracker frame of now.
  Eigen::Vector3d place_mm(const ArmPosture& posture, std::size_t reflector) const;

  const config::CellConfig& config_;
  CellDevices& devices_;
  std::vector<std::string> names_;
  std::optional<std::size_t> one_;  ///< none: a reflector sits at each place, of which the first is measured
  CalibratedCell expected_;         ///< with the reflectors in the order of the cell file
  Eigen::Isometry3d X_now_first_ = Eigen::Isometry3d::Identity();
  bool placement_known_ = false;
  double reach_ = 1;
  std::optional<PoseChecker>
      sight_;  ///< what the tracker sees of several reflectors; none: the first is measured
};

}  // namespace truepose::daemon
