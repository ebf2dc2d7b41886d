#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <optional>
#include <string_view>

#include "proto/rsi/frame_codec.hpp"
#include "proto/rsi/frame_numbers.hpp"

namespace truepose::rsi {

/// Where the numbers of a robot frame stand. A controller writes the same elements, attributes and spaces in
/// every cycle, so that after the first frame only the numbers have to be read.
class FrameLayout {
 public:
  /// @param frame  one that decode_robot_frame() reads whole; where it is too large to be kept, no frame fits
  void learn(std::string_view frame) noexcept;
  /// Never another value than decode_robot_frame() has; nothing where the frame has another layout, or a
  /// number that is written in another way than with digits and a point.
  std::optional<RobotFrame> read(std::string_view frame) noexcept;

 private:
  /// What follows a text that does not change.
  enum class Slot : std::uint8_t { Six, Delay, Program, Ipoc, Skipped, End };
  struct Found {
    Slot slot = Slot::Skipped;
    std::size_t place = 0;  // Six: kAxes * element + attribute; Program: attribute
  };
  struct Step {
    Slot slot = Slot::End;
    std::uint8_t place = 0;
    std::uint16_t text = 0;  // its first word
    std::uint16_t text_bytes = 0;
  };
  using Word = std::uint64_t;
  static constexpr std::size_t kAxes = std::tuple_size_v<Axes>;
  static constexpr std::size_t kMostSteps = 128;

  static Found slot_of(std::string_view element, std::string_view attribute) noexcept;
  bool add_step(Found found, std::string_view text) noexcept;
  const char* behind_text(const Step& step, const char* at) const noexcept;
  const char* behind_slot(const Step& step, const char* at, WireNumbers& numbers) const noexcept;

  bool known_ = false;
  WireNumbers shape_;  // has what the frame has
  std::size_t steps_ = 0, words_ = 0;
  std::array<Step, kMostSteps> all_steps_{};
  std::array<Word, kMaxFrameBytes / sizeof(Word) + kMostSteps> all_words_{};  // of the texts
  // The frame that is read, and behind it NUL for who looks a word ahead.
  std::array<char, kMaxFrameBytes + sizeof(Word)> frame_{};
};

/// decode_robot_frame() for the frames of one controller. What has not the layout of the last frame that was
/// read whole is given to decode_robot_frame(), which decides on all that differs. No allocation, no
/// exception.
class RobotFrameDecoder {
 public:
  std::expected<RobotFrame, FrameError> decode(std::string_view datagram) noexcept;

 private:
  FrameLayout layout_;
};

}  // namespace truepose::rsi
