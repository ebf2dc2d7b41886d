#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "proto/rsi/ethernet_config.hpp"

namespace truepose::rsi {

/// Room enough for every frame that this codec writes.
inline constexpr std::size_t kMaxFrameBytes = 2048;

using Axes = std::array<double, 6>;

/// A pose in KUKA's own terms: X Y Z in mm, A B C in deg.
struct CartesianPose {
  double x_mm = 0, y_mm = 0, z_mm = 0, a_deg = 0, b_deg = 0, c_deg = 0;

  bool operator==(const CartesianPose&) const = default;
};

enum class FrameFault {
  Malformed,   ///< not one well-formed document; `offset` says where
  WrongRoot,   ///< not <Rob> or <Sen>, or not of the configured Type
  Missing,     ///< IPOC, or an attribute of an element that is there
  Duplicate,   ///< an element or attribute that comes twice
  BadNumber,   ///< not a finite number of the right kind
  TooMany,     ///< an element that matters has more attributes than are looked at
  BufferFull,  ///< encoding: the buffer is too small
};

/// Why a frame, or an element of it, was not believed. Views point to constants or into the codec, never
/// into the datagram.
struct FrameError {
  FrameFault fault = FrameFault::Malformed;
  std::string_view element;    ///< "AIPos", "IPOC"; empty for Malformed
  std::string_view attribute;  ///< "A3"; empty where the element itself is meant
  std::size_t offset = 0;      ///< byte of the frame where it was noticed

  bool operator==(const FrameError&) const = default;
};

/// Signals of the robot program in the SEND list, in attributes of kProgramElement; empty where they are not
/// sent.
struct ProgramSignals {
  std::optional<std::int64_t> ask;    ///< Ask: 1 = the program wants to be corrected, 0 = it does not
  std::optional<std::int64_t> state;  ///< Pro, $PRO_STATE: 1 free, 2 reset, 3 active, 4 stopped, 5 ended
  std::optional<std::int64_t> mode;   ///< Mode, of operation: 1 T1, 2 T2, 3 AUT, 4 EXT
  std::optional<std::int64_t> override_percent;  ///< Ov, $OV_PRO
  std::optional<std::int64_t> cell;              ///< Cell, the status word that cell_signals() reads

  bool operator==(const ProgramSignals&) const = default;
};

/// What the controller says in one cycle. An element that its SEND list does not have is empty.
struct RobotFrame {
  std::uint64_t ipoc = 0;             ///< the controller's time stamp, to be echoed unchanged
  std::optional<CartesianPose> rist;  ///< actual pose of the active tool in the active base
  std::optional<CartesianPose> rsol;  ///< commanded pose
  std::optional<Axes> aipos_rad;      ///< actual axes; contain our correction
  std::optional<Axes> aspos_rad;      ///< commanded axes; without our correction
  std::optional<Axes> eipos;          ///< actual external axes E1..E6, mm or deg as on the wire
  std::optional<Axes> espos;          ///< commanded external axes, mm or deg as on the wire
  std::optional<std::int64_t> delay;  ///< late replies as the controller counts them
  ProgramSignals program;
  /// An element that is there, cannot be read and is therefore empty: the one that matters most.
  std::optional<FrameError> unread;

  bool operator==(const RobotFrame&) const = default;
};

inline constexpr std::int64_t kProgramActive = 3;  ///< ProgramSignals::state
inline constexpr std::int64_t kModeExt = 4;        ///< ProgramSignals::mode

/// SensorFrame::gain where there is no correction to wait for.
inline constexpr std::int64_t kGainNotArmed = -1, kGainNoModel = -2, kGainFault = -3;

/// What the PC answers.
struct SensorFrame {
  std::uint64_t ipoc = 0;
  std::optional<Axes> axis_correction_rad;
  std::optional<bool> stop;  ///< true asks the controller to leave RSI_MOVECORR
  /// Gain: 0..100, per cent of the correction that are ramped in; below 0 why there is none.
  std::optional<std::int64_t> gain;

  bool operator==(const SensorFrame&) const = default;
};

/// "AIPos.A3 is missing (at byte 120)"
std::string describe(const FrameError& error);

/// Controller to PC. Elements and attributes in any order, unknown ones skipped. What a correction is
/// computed from must be good: IPOC and ASPos, or AIPos where there is no ASPos. Any other element that
/// cannot be read is left empty and named in `unread`. No allocation, no exception; the time is linear in the
/// datagram.
std::expected<RobotFrame, FrameError> decode_robot_frame(std::string_view datagram) noexcept;

/// The number between the only <IPOC> and </IPOC> of a datagram that is otherwise not understood.
std::optional<std::uint64_t> readable_ipoc(std::string_view datagram) noexcept;

/// Writes the elements that `frame` has, in the order RIst RSol AIPos ASPos EIPos ESPos Delay Tp IPOC, as the
/// controller does: one line, no spaces before "/>".
/// @param decimals  the ETHERNET object's Precision, 0..15
std::expected<std::string_view, FrameError> encode_robot_frame(const RobotFrame& frame,
                                                               std::span<char> buffer,
                                                               int decimals = 4) noexcept;

/// PC to controller and back, with the names and the order of one ethernet configuration. What the
/// configuration does not receive is not written, and ignored when read. encode and decode do not allocate or
/// throw.
class SensorFrameCodec {
 public:
  explicit SensorFrameCodec(const EthernetConfig& config);

  /// Six decimals of a degree, IPOC as it was received, elements in the order of the RECEIVE list, IPOC last.
  std::expected<std::string_view, FrameError> encode(const SensorFrame& frame,
                                                     std::span<char> buffer) const noexcept;
  std::expected<SensorFrame, FrameError> decode(std::string_view datagram) const noexcept;

 private:
  std::string sentype_;
  std::string axis_correction_;  // empty = the configuration has none
  std::string stop_;
  bool stop_first_ = false;
  bool gain_ = false;
};

}  // namespace truepose::rsi
