#pragma once

#include <unistd.h>

namespace truepose::test {

/// While it lives, a process of root's has nobody's rights: root may write everywhere.
class AsNobody {
 public:
  AsNobody() {
    if (!root_) return;
    const bool became = ::setresuid(kNobody, kNobody, 0) == 0;
    static_cast<void>(became);  // the test fails where it did not
  }
  ~AsNobody() {
    if (!root_) return;
    const bool is_again = ::setresuid(0, 0, 0) == 0;
    static_cast<void>(is_again);
  }
  AsNobody(const AsNobody&) = delete;
  AsNobody& operator=(const AsNobody&) = delete;

 private:
  static constexpr uid_t kNobody = 65534;
  bool root_ = ::geteuid() == 0;
};

}  // namespace truepose::test
