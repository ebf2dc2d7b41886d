#pragma once

namespace truepose::daemon {

/// While it lives, one of a kind is under way, of which there is one at a time.
class Busy {
 public:
  explicit Busy(bool& flag) : flag_{flag} { flag_ = true; }
  ~Busy() { flag_ = false; }
  Busy(const Busy&) = delete;
  Busy& operator=(const Busy&) = delete;

 private:
  bool& flag_;
};

}  // namespace truepose::daemon
