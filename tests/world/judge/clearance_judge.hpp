#pragma once

#include <vector>

#include "tests/world/cell.hpp"
#include "tests/world/judge/arm.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// Judges that a campaign drives the arm clear of floor, tracker and obstacles: the lines from its shoulder
/// to its tool, without the body about them.
class ClearanceJudge {
 public:
  ClearanceJudge(Cell& cell, SoakLog& log);

  /// Looks at the arm, several times a second while a campaign measures.
  void look(bool campaign_measures);

 private:
  bool is_clear(const JointVector& q_rad) const;

  /// A post in the frame of the arm's base.
  struct Post {
    Arm::Vector from{}, to{};
    double radius_mm = 0;
  };
  static Post tracker_of(const Cell& cell);

  Cell& cell_;
  SoakLog& log_;
  std::vector<Arm> parts_;  // each as far as one of its points: shoulder, elbow, wrist, tool
  std::vector<Post> posts_;
  JointVector q_rad_;       // at the last look
  bool was_clear_ = false;  // then
};

}  // namespace truepose::world
