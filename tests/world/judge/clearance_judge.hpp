#pragma once

#include <vector>

#include "tests/world/cell.hpp"
#include "tests/world/judge/arm.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// Judges that a campaign drives the arm clear of floor, tracker and obstacles: its body beyond the shoulder,
/// by the capsules of the robot file, and its tool.
class ClearanceJudge {
 public:
  ClearanceJudge(Cell& cell, SoakLog& log);

  /// Looks at the arm, several times a second while a campaign measures.
  void look(bool campaign_measures);

 private:
  bool is_clear(const JointVector& q_rad) const;

  /// A capsule in the frame of the arm's base.
  struct Post {
    Arm::Vector from{}, to{};
    double radius_mm = 0;
  };
  /// One that a link carries: its ends in the places of the arms' reflectors.
  struct Body {
    Arm from, to;
    double radius_mm = 0;
  };
  static Post tracker_of(const Cell& cell);
  static Body body_of(const Arm& until, const Capsule& capsule);

  Cell& cell_;
  SoakLog& log_;
  std::vector<Body> bodies_;
  std::vector<Post> posts_;
  JointVector q_rad_;       // at the last look
  bool was_clear_ = false;  // then
};

}  // namespace truepose::world
