#include "daemon/control/disk_advice.hpp"

#include <cerrno>

namespace truepose::daemon {

std::string disk_advice(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      return "make room on the disk";
    case EROFS:  // also what the kernel makes of a disk that fails
      return "see in the kernel's log why (dmesg), and mount it to be written to";
    default:
      return "check the disk";
  }
}

}  // namespace truepose::daemon
