#include "tools/truepose/krl/program_compensation.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <sstream>

#include "core/arm/forward.hpp"
#include "core/arm/pose_inverse.hpp"
#include "core/frames/tool_frame.hpp"
#include "core/math/angles.hpp"
#include "proto/krl/frame_data.hpp"
#include "proto/krl/offset.hpp"
#include "proto/krl/variables.hpp"
#include "proto/text/kuka_names.hpp"

namespace truepose::tools {
namespace {

using krl::FrameValue;
using krl::Point;
using krl::PositionForm;
using krl::Spot;
using krl::Step;
using State = FrameValue::State;

// Arms are wrong by millimetres.
constexpr double kLargestMove_mm = 50;
// What the inverse and the forward kinematics leave of a position that needs no change.
constexpr double kUnmoved_mm = 1e-7;
constexpr double kUnmoved_rad = 1e-9;
constexpr double kSameJoints_rad = 1e-6;

constexpr std::string_view kNearestNote =
    "S and T are missing, here first: such positions are taken as the controller would come to them, nearest "
    "to the position before";
constexpr int kAccurateRobotBit = 0b10000;  // of S
constexpr std::string_view kAccurateRobotNote =
    "S has bit 4, here first: taught on an arm with KUKA's own accuracy model; where that is active, two "
    "corrections would add up";

constexpr std::string_view kDampedNote =
    "next to the wrist singularity, here first: the TCP comes to its position, its orientation is corrected "
    "as far as axes 4 and 6 need not turn far for it (--singularity-limit)";

constexpr std::string_view kGivesWayNote =
    "next to the wrist singularity, here first: the TCP comes only a part of the way to its position, as its "
    "orientation would be worse than without a correction; move the point away from there";

constexpr std::string_view kSearchedNote =
    "axes 4, 5 and 6 of the arm do not meet: positions are found by search, T and the position before say which, "
    "and S does not count";

struct Correction {
  std::array<double, 6> values{};  // as in Position, mm and deg
  JointVector q;                   // that the controller comes to by them
  StatusTurn status_turn;
  double mm = 0, deg = 0;
  bool is_none = false;
  bool is_damped = false;  // its orientation is not what it should be
  bool gives_way = false;  // nor its position
};

std::optional<int> bits(const std::optional<krl::Number>& number) {
  return number ? std::optional(static_cast<int>(number->value)) : std::nullopt;
}

JointVector joints_of(const krl::Position& position) {
  JointVector q(6);
  for (std::size_t i = 0; i < 6; ++i) q[static_cast<Eigen::Index>(i)] = position.values[i].value * kRadPerDeg;
  return q;
}

JointVector joints_of(const std::array<double, 6>& axes_deg) {
  JointVector q(6);
  for (std::size_t i = 0; i < 6; ++i) q[static_cast<Eigen::Index>(i)] = axes_deg[i] * kRadPerDeg;
  return q;
}

using Kind = krl::HindranceKind;

/// Why a frame of a motion is not known.
std::optional<krl::Hindrance> uncertain(const FrameValue& frame, bool is_tool) {
  const char* const name = is_tool ? "tool" : "base";
  const char* const capitals = is_tool ? "TOOL" : "BASE";
  switch (frame.state) {
    case State::Known:
      return std::nullopt;
    case State::Unset:
      return krl::hindrance<Kind::FrameUnset>(name, capitals);
    case State::NoData:
      return krl::hindrance<Kind::FrameData>(capitals, frame.number);
    case State::Moving:
      return krl::hindrance<Kind::FrameMoving>(frame.number);
    case State::Written:
      return krl::Hindrance{message<Kind::FrameWritten>(capitals, frame.number), frame.set};
    case State::Unordered:
      return krl::Hindrance{message<Kind::FrameOrder>(std::string{"the "} + name), frame.set};
    case State::Computed:
      break;
  }
  return krl::hindrance<Kind::Computed>(std::string{"the "} + name + " is");
}

/// Without a tool or a base no motion of a program can be corrected; the operator can give it.
bool can_be_given(const FrameValue& frame) {
  return frame.state == State::Unset || frame.state == State::NoData;
}

class Compensator {
 public:
  Compensator(const krl::Program& program, const RobotModel& nominal, const StatusTurnInverse& inverse,
              const RobotModel& calibrated, const CompensationOptions& bounds, const RealFrames& real,
              bool is_archive)
      : program_{program},
        nominal_{nominal},
        inverse_{inverse},
        calibrated_{calibrated},
        bounds_{bounds},
        real_{real},
        is_archive_{is_archive},
        states_(program.points.size()) {
    result_.left = program.left;
    result_.notes = program.notes;
  }

  std::expected<ProgramCompensation, krl::ProgramFault> run() {
    if (inverse_.searches() && !program_.steps.empty()) note_once(kSearchedNote, program_.steps.front().spot);
    for (const Step& step : program_.steps) {
      if (const auto done = visit(step); !done) return std::unexpected(done.error());
    }
    // Which positions change is known by now: what is computed from them follows.
    correct_offsets();
    for (std::size_t i = 0; i < states_.size(); ++i) {
      const Point& point = program_.points[i];
      const bool is_gone_to = states_[i].first != nullptr || states_[i].is_left;
      if (!point.is_changeable || !is_gone_to) continue;
      ++result_.points;
      const auto& correction = states_[i].correction;
      if (!correction || correction->is_none) continue;
      result_.changes.push_back(
          {point.position.spot, std::string(point.name), correction->mm, correction->deg});
      add_edits(point, *correction);
    }
    return std::move(result_);
  }

 private:
  /// Where a step leads: the joints that the program asks for, and those that it will ask for.
  struct Place {
    JointVector before, after;
  };

  /// What is known of a point from its first motion on.
  struct PointState {
    const Step* first = nullptr;
    JointVector q;
    std::optional<Correction> correction;
    bool is_left = false;
  };

  std::expected<void, krl::ProgramFault> visit(const Step& step) {
    if (step.offset) {
      const auto q = nominal_joints_of_offset(step, program_.offsets[*step.offset], q_near_);
      q_near_ = q ? std::optional(*q) : std::nullopt;
      return {};
    }
    if (!step.point) {
      q_near_.reset();
      return {};
    }
    const Point& point = program_.points[*step.point];
    const bool is_ours = point.is_changeable;
    if (point.position.form == PositionForm::Cartesian) {
      const bool no_tool = can_be_given(tool(step)), no_base = can_be_given(base(step));
      if (is_ours && !step.fixed_tool && !is_archive_ && (no_tool || no_base)) {
        const auto why = no_tool ? uncertain(tool(step), true) : uncertain(base(step), false);
        return std::unexpected(krl::ProgramFault{step.spot, sentences(why->message)});
      }
    }
    const auto q = nominal_joints(step, point);
    q_near_ = q ? std::optional(*q) : std::nullopt;
    if (is_ours) use(step, point, q);
    return {};
  }

  std::expected<JointVector, krl::Hindrance> nominal_joints(const Step& step, const Point& point) {
    if (point.position.form == PositionForm::Axes) return joints_of(point.position);
    if (const auto why = uncertain_frames(step)) return std::unexpected(*why);
    const krl::Position& position = point.position;
    const auto status = bits(position.status), turn = bits(position.turn);
    if (!(status && turn) && q_near_) note_once(kNearestNote, step.spot);
    if (status && (*status & kAccurateRobotBit)) note_once(kAccurateRobotNote, step.spot);
    auto q = inverse_.solve(flange_of(step, krl::pose_of(position)), status, turn, q_near_);
    if (q) return std::move(*q);
    const bool is_undecided = !(status && turn) && !q_near_;
    return std::unexpected(is_undecided ? krl::hindrance<Kind::Undecided>(q.error())
                                        : krl::hindrance<Kind::Reach>(q.error()));
  }

  std::optional<krl::Hindrance> uncertain_frames(const Step& step) const {
    if (step.fixed_tool) return krl::hindrance<Kind::FixedTool>();
    const auto why = uncertain(tool(step), true);
    return why ? why : uncertain(base(step), false);
  }

  std::expected<Correction, krl::Hindrance> correction(const Step& step, const Point& point,
                                                       const JointVector& q) {
    const bool of_axes = point.position.form == PositionForm::Axes;
    const Eigen::Isometry3d X = of_axes ? forward_kinematics(nominal_, q) : krl::pose_of(point.position);
    return correction(
        step, X, of_axes, q,
        StatusTurn{bits(point.position.status).value_or(0), bits(point.position.turn).value_or(0)});
  }

  /// @param X   of the flange in the robot's base where it is of axes, else of the TCP in the base
  /// @param q   the nominal joints there
  std::expected<Correction, krl::Hindrance> correction(const Step& step, const Eigen::Isometry3d& X,
                                                       bool of_axes, const JointVector& q,
                                                       const StatusTurn& given) {
    const bool knows_tcp = tool(step).state == State::Known;
    const Eigen::Vector3d p_F_mm =
        knows_tcp ? Eigen::Vector3d(tool(step).X.translation()) : Eigen::Vector3d(0, 0, 0);
    const auto solved = compensation(step).at_pose(of_axes ? X : wanted_flange(step, X), q, p_F_mm);
    if (!solved)
      return std::unexpected(krl::hindrance<Kind::NoCorrection>(cause_of(solved.error(), nominal_),
                                                                way_out(solved.error().kind)));

    const Eigen::Isometry3d X_BF = forward_kinematics(nominal_, solved->q);
    const Eigen::Isometry3d X_new = of_axes ? X_BF : tcp_of(step, X_BF);
    const double rad = angle_between(X.linear(), X_new.linear());
    Correction result{.mm = (X_new.translation() - X.translation()).norm(), .deg = rad * kDegPerRad};
    if (result.mm > kLargestMove_mm)
      return std::unexpected(krl::hindrance<Kind::Large>(result.mm, kLargestMove_mm));

    result.gives_way = solved->residual_mm > kUnmoved_mm;
    result.is_damped = !result.gives_way && solved->damped && solved->residual_rad > kUnmoved_rad;
    result.is_none = result.mm < kUnmoved_mm && rad < kUnmoved_rad;
    result.q = solved->q;
    result.status_turn = inverse_.of_joints(solved->q, given);
    const Eigen::Vector3d abc = kuka_abc_deg(X_new.linear());
    for (std::size_t i = 0; i < 6; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      result.values[i] = of_axes ? solved->q[k] * kDegPerRad : i < 3 ? X_new.translation()[k] : abc[k - 3];
    }
    return result;
  }

  // ---- Motions to what is computed from a point, or from where the arm stands

  /// As the program has it. @param q_before  where the arm comes from
  std::expected<JointVector, krl::Hindrance> nominal_joints_of_offset(
      const Step& step, const krl::Offset& offset, const std::optional<JointVector>& q_before) {
    const std::optional<JointVector> near = near_of(offset, q_before);
    if (!near) return std::unexpected(krl::hindrance<Kind::Start>());
    if (offset.kind == krl::Offset::Kind::Axes)
      return JointVector(*near + joints_of(krl::numbers_of(offset)));
    if (const auto why = uncertain_frames(step)) return std::unexpected(*why);
    const auto point = point_pose(offset, false);
    auto q = inverse_.solve(flange_of(step, krl::target_of(offset, tcp(step, *near), point)), std::nullopt,
                            std::nullopt, *near);
    if (!q) return std::unexpected(krl::hindrance<Kind::Reach>(q.error()));
    return std::move(*q);
  }

  /// The branch is that of where the arm comes from, or of the point that it is computed from.
  std::optional<JointVector> near_of(const krl::Offset& offset,
                                     const std::optional<JointVector>& q_before) const {
    if (q_before || !offset.point) return q_before;
    const PointState& state = states_[*offset.point];
    return state.first ? std::optional(state.q) : std::nullopt;
  }

  /// Of the point that it is computed from, as the program has it or will have it.
  Eigen::Isometry3d point_pose(const krl::Offset& offset, bool is_after) const {
    if (!offset.point) return Eigen::Isometry3d::Identity();
    const auto& correction = states_[*offset.point].correction;
    if (is_after && correction && !correction->is_none) return krl::pose_of_numbers(correction->values);
    return krl::pose_of(program_.points[*offset.point].position);
  }

  /// The TCP's pose in the base.
  Eigen::Isometry3d tcp(const Step& step, const JointVector& q) const {
    return tcp_of(step, forward_kinematics(nominal_, q));
  }

  /// The numbers by which the motion leads there, from where the arm will come.
  std::array<double, 6> numbers_to(const Step& step, const krl::Offset& offset, const JointVector& q_before,
                                   const Correction& target) const {
    if (offset.kind != krl::Offset::Kind::Axes)
      return krl::offset_to(offset, tcp(step, q_before), point_pose(offset, true),
                            krl::pose_of_numbers(target.values));
    std::array<double, 6> numbers = target.values;
    for (std::size_t i = 0; i < 6; ++i) numbers[i] -= q_before[static_cast<Eigen::Index>(i)] * kDegPerRad;
    return numbers;
  }

  void correct_offsets() {
    std::optional<Place> place;
    for (const Step& step : program_.steps) {
      if (step.point) {
        place = place_of_point(step);
      } else if (step.offset) {
        place = correct_offset(step, program_.offsets[*step.offset], place);
      } else {
        place.reset();
      }
    }
  }

  std::optional<Place> place_of_point(const Step& step) {
    const PointState& state = states_[*step.point];
    if (state.first && state.correction) return Place{state.q, state.correction->q};
    q_near_.reset();
    const auto q = nominal_joints(step, program_.points[*step.point]);
    return q ? std::optional(Place{*q, *q}) : std::nullopt;
  }

  std::optional<Place> correct_offset(const Step& step, const krl::Offset& offset,
                                      const std::optional<Place>& from) {
    ++result_.points;
    const auto leave_it = [&](krl::Hindrance why) -> std::optional<Place> {
      const bool is_relative = !offset.point;
      result_.left.push_back({step.spot, {}, std::move(why), !is_relative});
      return std::nullopt;
    };
    const auto q = nominal_joints_of_offset(step, offset, from ? std::optional(from->before) : std::nullopt);
    if (!q) return leave_it(q.error());
    const bool of_axes = offset.kind == krl::Offset::Kind::Axes;
    const Eigen::Isometry3d X =
        of_axes ? forward_kinematics(nominal_, *q)
                : krl::target_of(offset, tcp(step, from ? from->before : *q), point_pose(offset, false));
    const auto result = correction(step, X, of_axes, *q, {});
    if (!result) return leave_it(result.error());
    const std::array<double, 6> numbers = numbers_to(step, offset, from ? from->after : *q, *result);
    if (add_offset_edits(offset, numbers))
      result_.changes.push_back({offset.spot, {}, result->mm, result->deg});
    return Place{*q, result->q};
  }

  /// @return whether something changes
  bool add_offset_edits(const krl::Offset& offset, const std::array<double, 6>& numbers) {
    const bool of_axes = offset.kind == krl::Offset::Kind::Axes;
    const auto& names = of_axes ? kAxisNames : kPoseNames;
    std::vector<krl::Edit> edits;
    std::string more;
    for (std::size_t i = 0; i < 6; ++i) {
      const krl::Number old = offset.numbers[i].value_or(krl::Number{});
      double value = numbers[i];
      // A turn of 360 deg more is the same turn, but for axes.
      if (!of_axes && i >= 3) value = old.value + std::remainder(value - old.value, 360.0);
      if (!krl::is_changed(old, value)) continue;
      if (offset.numbers[i]) {
        edits.push_back({old.begin, old.end, krl::number_text(value)});
      } else {
        more += "," + std::string(names[i]) + " " + krl::number_text(value);
      }
    }
    if (!more.empty()) edits.push_back({offset.closed_at, offset.closed_at, more});
    if (edits.empty()) return false;
    std::ranges::move(edits, std::back_inserter(result_.edits[offset.spot.file]));
    return true;
  }

  void leave(const Step& step, krl::Hindrance why) {
    PointState& state = states_[*step.point];
    state.correction.reset();
    if (state.is_left) return;
    state.is_left = true;
    const Point& point = program_.points[*step.point];
    // A program that was corrected before does not go to a corrected position any more.
    if (state.first && state.first->spot.file != step.spot.file)
      result_.left.push_back({state.first->spot,
                              std::string(point.name),
                              {message<Kind::Conflict>("by another program"), step.spot},
                              true});
    result_.left.push_back({step.spot, std::string(point.name), std::move(why), true});
  }

  void use(const Step& step, const Point& point, const std::expected<JointVector, krl::Hindrance>& q) {
    PointState& state = states_[*step.point];
    if (state.is_left) return;
    // Other joints for the same numbers: either correction would be wrong at the other motion, and a second
    // point is the programmer's to teach.
    if (state.first && !(q && (state.q - *q).cwiseAbs().maxCoeff() < kSameJoints_rad))
      return leave(step, {message<Kind::Conflict>("before"), state.first->spot});
    if (state.first) return;
    if (!q) return leave(step, q.error());
    state.first = &step;
    state.q = *q;
    auto result = correction(step, point, *q);
    if (!result) return leave(step, result.error());
    if (result->gives_way) note_once(kGivesWayNote, step.spot);
    if (result->is_damped) note_once(kDampedNote, step.spot);
    state.correction = *result;
  }

  void note_once(std::string_view text, Spot spot) {
    if (noted_.insert(text).second) result_.notes.push_back({spot, std::string(text)});
  }
  void add_edits(const Point& point, const Correction& correction) {
    std::vector<krl::Edit> edits;
    const bool of_axes = point.position.form == PositionForm::Axes;
    for (std::size_t i = 0; i < 6; ++i) {
      const krl::Number& number = point.position.values[i];
      double value = correction.values[i];
      // A = -180 and A = 180 are the same angle.
      const double difference = value - number.value;
      if (!of_axes && i >= 3 && !krl::is_changed(number, number.value + std::remainder(difference, 360.0)))
        continue;
      if (krl::is_changed(number, value))
        edits.push_back({number.begin, number.end, krl::number_text(value)});
    }
    if (!of_axes) add_status_turn_edits(point, correction.status_turn, edits);
    if (!edits.empty()) std::ranges::move(edits, std::back_inserter(result_.edits[point.position.spot.file]));
  }

  void add_status_turn_edits(const Point& point, const StatusTurn& now, std::vector<krl::Edit>& edits) {
    const auto write = [&](const char* name, const std::optional<krl::Number>& number, int mask, int value) {
      if (!number) return;
      const int old = static_cast<int>(number->value), changed = (old & ~mask) | value;
      if (changed == old) return;
      edits.push_back({number->begin, number->end, std::to_string(changed)});
      std::ostringstream text;
      if (!point.name.empty()) text << point.name << ": ";
      text << name << " becomes " << changed << " (was " << old << "), an axis goes across its boundary";
      result_.notes.push_back({point.position.spot, text.str()});
    };
    write("S", point.position.status, kStatusBits, now.status);
    write("T", point.position.turn, kTurnBits, now.turn);
  }

  /// Of the arm with the step's tool.
  const TargetCompensation& compensation(const Step& step) {
    const FrameValue& active = tool(step);
    const auto real = active.state == State::Known ? real_.tools.find(active.number) : real_.tools.end();
    const int number = real == real_.tools.end() ? 0 : active.number;
    const auto found = compensations_.find(number);
    if (found != compensations_.end()) return found->second;
    const RobotModel arm = number == 0 ? calibrated_ : with_tool(calibrated_, real->second, active.X);
    return compensations_.try_emplace(number, nominal_, arm, bounds_).first->second;
  }

  const FrameValue& tool(const Step& step) const { return program_.frames[step.tool]; }
  const FrameValue& base(const Step& step) const { return program_.frames[step.base]; }
  /// The flange's pose in the robot base for a TCP's pose in the base, and back.
  Eigen::Isometry3d flange_of(const Step& step, const Eigen::Isometry3d& X) const {
    return base(step).X * X * tool(step).X.inverse();
  }
  /// The same where the base truly is.
  Eigen::Isometry3d wanted_flange(const Step& step, const Eigen::Isometry3d& X) const {
    const auto found = real_.bases.find(base(step).number);
    return (found == real_.bases.end() ? base(step).X : found->second) * X * tool(step).X.inverse();
  }
  Eigen::Isometry3d tcp_of(const Step& step, const Eigen::Isometry3d& X_BF) const {
    return base(step).X.inverse() * X_BF * tool(step).X;
  }

  const krl::Program& program_;
  const RobotModel& nominal_;
  const StatusTurnInverse& inverse_;
  const RobotModel& calibrated_;
  const CompensationOptions& bounds_;
  const RealFrames& real_;
  bool is_archive_;
  std::map<int, TargetCompensation> compensations_;  // by the tool's number; 0: as the program has it
  std::vector<PointState> states_;
  std::optional<JointVector> q_near_;  // of the target before
  std::set<std::string_view> noted_;
  ProgramCompensation result_;
};

}  // namespace

std::expected<ProgramCompensation, krl::ProgramFault> compensate_program(
    const krl::Program& program, const RobotModel& nominal, const StatusTurnInverse& inverse,
    const RobotModel& calibrated, const CompensationOptions& bounds, const RealFrames& real,
    bool is_archive) {
  return Compensator(program, nominal, inverse, calibrated, bounds, real, is_archive).run();
}

}  // namespace truepose::tools
