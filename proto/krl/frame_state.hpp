#pragma once

#include <map>
#include <vector>

#include "proto/krl/frame_data.hpp"
#include "proto/krl/program.hpp"
#include "proto/krl/variables.hpp"

namespace truepose::krl {

/// Tool and base in force, while statements are read one after the other.
class FrameState {
 public:
  FrameState(const Variables& variables, const FrameData& data, const StartFrames& start);

  /// A routine starts, or BAS(#INITMOV): what that sets is up to the cell's own BAS, so what was given for the
  /// start holds again, and without it nothing is known.
  void start();

  /// Carries out a statement that may set the tool or the base: $TOOL=, $BASE=, $IPO_MODE=, FDAT_ACT=, BAS(),
  /// or the list of assignments behind WITH.
  /// @param routine  number of the routine that it stands in
  std::expected<void, Fault> carry_out(Tokens statement, std::size_t routine);
  std::expected<void, Fault> carry_out_list(Tokens assignments, std::size_t routine);

  std::size_t tool() const { return now_.tool; }
  std::size_t base() const { return now_.base; }
  bool fixed_tool() const { return now_.fixed_tool; }
  const std::vector<FrameValue>& frames() const { return frames_; }

  /// What is in force, to be brought back later.
  struct InForce {
    std::size_t tool = 0, base = 0;  // of frames()
    bool fixed_tool = false;
    bool operator==(const InForce&) const = default;
  };
  InForce in_force() const { return now_; }
  void restore(InForce in_force) { now_ = in_force; }

 private:
  enum class Kind { Tool, Base };
  void set(Kind kind, std::size_t frame) { (kind == Kind::Tool ? now_.tool : now_.base) = frame; }
  std::size_t add(FrameValue value);
  std::size_t numbered(Kind kind, std::optional<int> number, Spot spot);
  std::size_t computed(Spot spot);
  std::expected<std::size_t, Fault> value_of(Kind kind, Tokens expression, std::size_t routine);
  std::optional<int> number_of(Kind kind, Tokens expression, std::size_t routine) const;
  const MotionData* motion_data(Tokens expression, std::size_t routine) const;
  std::expected<void, Fault> set_motion_data(Tokens expression, std::size_t routine);
  bool tells_fixed_tool(Tokens expression, std::size_t routine) const;
  void carry_out_bas(Tokens arguments);

  const Variables& variables_;
  const FrameData& data_;
  std::vector<FrameValue> frames_;
  std::map<std::pair<Kind, int>, std::size_t> numbered_;
  InForce started_, now_;
};

}  // namespace truepose::krl
