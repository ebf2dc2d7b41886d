#pragma once

#include <cstdint>
#include <optional>

namespace truepose::daemon {

/// What the controller's count of cycles without a reply in time (Delay) tells of ours. Whether it adds them
/// up or counts those in a row is not documented: what is concluded here holds for both.
class ReplyReceipts {
 public:
  struct Verdict {
    bool taken = false;      ///< the reply since the count before was taken
    bool missed = false;     ///< there was a reply, and it is not known to have been taken
    bool alive = false;      ///< every cycle since is counted: the session is the same as before
    std::uint64_t late = 0;  ///< replies that were sent and came late or not at all
  };

  void restart() noexcept { *this = {}; }
  /// The count as it was when a reply to that same cycle went out, as far as is known.
  void resume(std::optional<std::int64_t> delay) noexcept {
    restart();
    before_ = delay;
    replies_ = 1;
  }
  void replied() noexcept { ++replies_; }
  std::optional<std::int64_t> last() const noexcept { return before_; }

  /// @param delay    of the frame that came now, where it has one
  /// @param elapsed  cycles since the frame before
  Verdict read(std::optional<std::int64_t> delay, std::uint64_t elapsed) noexcept;

 private:
  std::optional<std::int64_t> before_;
  std::int64_t cycles_ = 0;   // since `before_`
  std::int64_t replies_ = 0;  // sent in these cycles
};

}  // namespace truepose::daemon
