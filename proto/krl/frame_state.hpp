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
  /// @param variables, config  what the program and $config.dat declare; they and data outlive the state
  FrameState(const Variables& variables, const Variables& config, const FrameData& data,
             const StartFrames& start);

  /// What is in force at a motion.
  struct InForce {
    std::size_t tool = 0, base = 0;  ///< of frames()
    bool fixed_tool = false;
    bool operator==(const InForce&) const = default;
  };
  const InForce& in_force() const { return now_; }
  void restore(const InForce& in_force) { now_ = in_force; }
  const std::vector<FrameValue>& frames() const { return frames_; }

  /// A routine starts, or BAS(#INITMOV): what that sets is up to the cell's own BAS, so what was given for
  /// the start holds again, and without it nothing is known.
  void start() { now_ = started_; }

  /// Carries out a statement that may set the tool or the base: $TOOL=, $BASE=, $IPO_MODE=, FDAT_ACT=, BAS().
  /// @param routine  number of the routine that it stands in
  std::expected<void, Fault> carry_out(Tokens statement, std::size_t routine);

  /// The same for the assignments behind WITH, which commas separate.
  std::expected<void, Fault> carry_out_list(Tokens assignments, std::size_t routine);

 private:
  enum class Kind { Tool, Base };
  void set(Kind kind, std::size_t frame) { (kind == Kind::Tool ? now_.tool : now_.base) = frame; }
  void set_motion_data(Tokens expression, Spot spot, std::size_t routine);
  void carry_out_bas(Tokens arguments, std::size_t routine);
  std::expected<std::size_t, Fault> value_of(Kind kind, Tokens expression, std::size_t routine);
  const Variable* find(std::string_view name, std::size_t routine) const;
  std::optional<MotionData> motion_data(Tokens expression, std::size_t routine) const;
  std::optional<int> number(Kind kind, Tokens expression, std::size_t routine) const;
  std::size_t numbered(Kind kind, std::optional<int> number, Spot spot);
  std::size_t add(const FrameValue& value);

  const Variables& variables_;
  const Variables& config_;
  const FrameData& data_;
  std::vector<FrameValue> frames_;
  std::map<std::pair<Kind, int>, std::size_t> numbered_;
  InForce started_, now_;
};

}  // namespace truepose::krl
