#pragma once

#include <Eigen/Core>
#include <array>
#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "core/data/measurement.hpp"
#include "core/simulate/tracker_instrument.hpp"
#include "drivers/clock.hpp"

namespace truepose::sim {

/// What the simulated tracker could see at one moment.
struct TargetSight {
  /// True centre of the SMR in the tracker's frame, mm; nothing while the beam cannot return from it (turned
  /// out of its acceptance cone, or hidden by the arm).
  std::optional<Eigen::Vector3d> p_WS_mm;
  std::vector<std::optional<Eigen::Vector3d>> others_mm{};  ///< the same of its further SMRs
  Eigen::Matrix3d R_WT = Eigen::Matrix3d::Identity();       ///< of the first, where it is a 6-D target
};

/// The SMRs that the simulated arm carries. Asked from the tracker's executor; must not block.
class SimulatedTarget {
 public:
  virtual ~SimulatedTarget() = default;
  virtual TargetSight look() const = 0;
};

/// One measured point of a target that truly stands at `p_true_mm`: its scatter is that of the whole
/// measurement, not of the single readings that it averages. mm, tracker frame.
using TrackerNoise = std::function<Eigen::Vector3d(const Eigen::Vector3d& p_true_mm)>;

/// One measured orientation of a 6-D target whose axes truly stand so in the tracker's frame.
using OrientationNoise = std::function<MeasuredOrientation(const Eigen::Matrix3d& R_true)>;

/// In what a tracker is wrong, or says wrong things.
struct TrackerDisturbance {
  Eigen::Vector3d moved_mm{0, 0,
                           0};  ///< by which all that it sees has moved since it was set up: it was pushed
  Eigen::Vector3d bias_mm{0, 0, 0};  ///< of what it measures
  std::optional<double> std_mm;      ///< that it reports for each axis, whatever it is
  std::optional<Eigen::Vector3d>
      stray_mm;         ///< from ours to another reflector, which its search finds instead
  bool busy = false;    ///< with a request of another client: refuses every command
  bool silent = false;  ///< answers and reports nothing
  bool storms = false;  ///< reports changes of its state without end
  double temperature_c = 20, pressure_mbar = 1013.25, humidity_percent = 50;  ///< that it reports

  Air station_air() const { return {temperature_c, pressure_mbar, humidity_percent}; }
};

/// A kind of reflector that the tracker knows.
struct ReflectorBall {
  std::string_view name;
  double radius_mm;
};
inline constexpr std::array kReflectorBalls{ReflectorBall{"CCR-1.5in", 19.05},
                                            ReflectorBall{"CCR-0.5in", 6.35}};

/// Where the tracker's own nest holds a reflector, in the tracker's frame, mm. Invented: no public source
/// says it.
inline const Eigen::Vector3d kHomeNest_mm{0, -200, 0};

/// Readings that one measurement averages.
inline constexpr int kReadings = 10;

/// A measurement of so many readings.
struct MeanReading {
  Eigen::Vector3d p_mm{0, 0, 0};
  Eigen::Vector3d std_mm{0, 0, 0};  ///< of the mean

  static MeanReading of(const std::vector<Eigen::Vector3d>& readings_mm);
};

/// A simulated tracker without its protocol: where it points, what it sees, has locked and reads there, and
/// in what it errs.
class TrackerBeam {
 public:
  /// @param clock    outlives it, as does the target
  /// @param speedup  so much faster its warmth and its stand change
  TrackerBeam(const drivers::Clock& clock, const SimulatedTarget& target, TrackerNoise noise,
              TrackerInstrument instrument, double speedup)
      : clock_{clock},
        target_{target},
        noise_{std::move(noise)},
        instrument_{std::move(instrument)},
        speedup_{speedup} {}

  void disturb(const TrackerDisturbance& disturbance) { disturbance_ = disturbance; }
  const TrackerDisturbance& disturbance() const { return disturbance_; }
  const TrackerInstrument& instrument() const { return instrument_; }
  /// Something stands in the beam for so long.
  void block(std::chrono::milliseconds duration);

  bool locked() const { return locked_.has_value(); }
  int face() const { return face_; }
  /// Where the beam points: the reflector's centre while one is locked.
  const Eigen::Vector3d& aim_mm() const { return aim_mm_; }
  void point_at(const Eigen::Vector3d& p_mm);
  /// Comes to point where it did, with no reflector locked.
  void turn_over();
  void initialise();
  /// Points at its own nest in face 1, and locks the reflector there.
  void come_home();

  /// The reflector nearest to a point within a radius, and where it is seen.
  std::optional<Eigen::Vector3d> find(const Eigen::Vector3d& p_mm, double radius_mm) const;
  /// Locks the reflector that is seen nearest to where the beam points. @return whether there is one
  bool lock_within(double radius_mm);
  void release() { locked_.reset(); }
  /// Goes after the reflector that is locked. @return whether it has just been lost
  bool follow();

  /// One reading of where it points, for the mean of kReadings.
  /// @param index  refraction by which the distance is corrected
  Eigen::Vector3d reading(double index) const;
  /// The same of its orientation; nothing where it is not that of the arm's first reflector.
  std::optional<MeasuredOrientation> orientation(const OrientationNoise& noise) const;

 private:
  /// One of those on the arm, from 0, then those in nests of the cell; the stray one; the one in its own
  /// nest.
  using Reflector = std::size_t;

  std::optional<Eigen::Vector3d> place_of(Reflector reflector, const TargetSight& sight) const;
  std::optional<Eigen::Vector3d> seen(Reflector reflector) const;
  std::optional<Reflector> nearest_to(const Eigen::Vector3d& p_mm, double radius_mm) const;
  std::chrono::duration<double> age() const;

  const drivers::Clock& clock_;
  const SimulatedTarget& target_;
  const TrackerNoise noise_;
  const TrackerInstrument instrument_;
  const double speedup_;
  const drivers::TimePoint switched_on_ = clock_.now();
  TrackerDisturbance disturbance_;
  std::optional<Reflector> locked_;
  Eigen::Vector3d stray_mm_{0, 0, 0};  ///< where the stray reflector stands that was locked last
  Eigen::Vector3d aim_mm_{1000, 0, 0};
  drivers::TimePoint blocked_until_;
  int face_ = 1;
};

}  // namespace truepose::sim
