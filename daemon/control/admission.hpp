#pragma once

#include <boost/asio/awaitable.hpp>
#include <expected>
#include <string>

#include "daemon/control/access_list.hpp"
#include "daemon/control/caller.hpp"
#include "daemon/control/control_server.hpp"
#include "daemon/control/failed_logins.hpp"
#include "proto/control/certificate.hpp"
#include "proto/control/session_proof.hpp"

namespace truepose::daemon {

/// Who is let in, by whichever port and protocol: by the token file's token or a proof of it, by a token or a
/// certificate of the access file. A peer that guesses is answered late.
class Admission {
 public:
  using Known = std::expected<Caller, std::string>;  ///< else one sentence

  Admission(const ControlServerParts& parts, const ControlLimits& limits, std::string token,
            AccessList access)
      : parts_{parts},
        limits_{limits},
        token_{std::move(token)},
        access_{std::move(access)},
        failed_logins_{limits.hello_window} {}

  Known by_token(const std::string& token) const;
  /// @param terms  without the server's nonce where no challenge was asked for
  Known by_proof(const std::string& proof, const control::SessionTerms& terms) const;
  Known by_certificate(const control::Certificate& shown) const;
  /// That the daemon knows the token too.
  std::string proof(const control::SessionTerms& terms) const;

  /// What becomes of an attempt: a wrong one is counted and logged, and each of a peer with many wrong ones
  /// is answered late, also where it is right.
  /// @param unsuspected  by what stands beyond guessing, where it is right
  boost::asio::awaitable<Known> judge(std::string peer, Known attempt, bool unsuspected = false);

  /// Reads the access file again where it has changed. @return whether it has
  bool refresh();
  /// Whether he still is who he was when he came in.
  bool still_known(const Caller& caller) const;

 private:
  const ControlServerParts& parts_;
  ControlLimits limits_;
  std::string token_;
  AccessList access_;
  FailedLogins failed_logins_;
};

}  // namespace truepose::daemon
