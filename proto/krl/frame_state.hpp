#pragma once

#include <map>
#include <vector>

#include "proto/krl/frame_data.hpp"
#include "proto/krl/program.hpp"
#include "proto/krl/variables.hpp"

namespace truepose::krl {

/// The first statements that set the tool and the base, of some.
struct FrameSettings {
  std::optional<Spot> tool, base;
  explicit operator bool() const { return tool || base; }
  /// Those of others behind them. @return whether they set what was not set
  bool add(const FrameSettings& others);
};

/// What a statement sets to some value, at once or later: by $TOOL=, $BASE=, $IPO_MODE=, FDAT_ACT=, BAS().
/// @param file  that it stands in
FrameSettings settings_of(const ProgramStatement& statement, std::size_t file);

/// Tool and base in effect, while statements are read one after the other.
class FrameState {
 public:
  /// @param variables, data  outlive the state
  FrameState(const Variables& variables, const FrameData& data, const StartFrames& start);

  /// The statements of another file follow. Its module's name outlives the state.
  /// @param interrupts  what is set there at any time, and so never known
  void begin(std::size_t file, std::string_view module, const FrameSettings& interrupts);

  /// What is in effect at a motion.
  struct InEffect {
    std::size_t tool = 0, base = 0;  ///< of frames()
    bool fixed_tool = false;
    bool operator==(const InEffect&) const = default;
  };
  const InEffect& in_effect() const { return now_; }
  void restore(const InEffect& in_effect) { now_ = in_effect; }
  const std::vector<FrameValue>& frames() const { return frames_; }

  /// @param number  of the routine whose statements follow
  void start_routine(std::size_t number);

  /// These statements may have been carried out meanwhile, or not.
  void unsettle(const FrameSettings& settings);

  /// Carries out a statement that may set the tool or the base: $TOOL=, $BASE=, $IPO_MODE=, FDAT_ACT=, BAS().
  void carry_out(const ProgramStatement& statement);

  /// The same for the assignments behind WITH.
  void carry_out(const std::vector<Assignment>& settings);

 private:
  enum class Kind { Tool, Base };
  void carry_out(const Assignment& assignment);
  void carry_out_bas(const Expression& call);
  void start();
  void set(Kind kind, std::size_t frame);
  void set_motion_data(const std::optional<MotionData>& data, Spot spot);
  std::size_t value_of(Kind kind, const Expression& expression);
  const Variable* find(const Expression& name) const;
  std::optional<MotionData> motion_data(const Expression& expression) const;
  /// Of an element of TOOL_DATA or BASE_DATA, or of the motion data that an expression is.
  std::optional<int> number(Kind kind, const Expression& expression) const;
  std::size_t numbered(Kind kind, std::optional<int> number, Spot spot);
  std::size_t add(const FrameValue& value);

  Spot spot_of(const Expression& expression) const { return {file_, expression.token.at}; }

  const Variables& variables_;
  const FrameData& data_;
  FrameSettings interrupts_;
  std::vector<FrameValue> frames_;
  std::map<std::pair<Kind, int>, std::size_t> numbered_;  // of this module
  InEffect given_, started_, now_;                        // given_: for the start of all files
  std::size_t file_ = 0;
  Scope scope_;
};

}  // namespace truepose::krl
