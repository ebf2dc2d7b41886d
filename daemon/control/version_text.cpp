#include "daemon/control/version_text.hpp"

#include <openssl/crypto.h>
#include <spdlog/version.h>
#include <sqlite3.h>

#include <Eigen/Core>
#include <boost/version.hpp>

#include "core/formatted.hpp"

namespace truepose::daemon {

std::string version_text(const std::string& program) {
  return program + " " TRUEPOSE_VERSION "\n" +
         formatted("with Boost %d.%d.%d, Eigen %d.%d.%d, %s, SQLite %s, spdlog %d.%d.%d",
                   BOOST_VERSION / 100000, BOOST_VERSION / 100 % 1000, BOOST_VERSION % 100,
                   EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION,
                   ::OpenSSL_version(OPENSSL_VERSION), ::sqlite3_libversion(), SPDLOG_VER_MAJOR,
                   SPDLOG_VER_MINOR, SPDLOG_VER_PATCH);
}

}  // namespace truepose::daemon
