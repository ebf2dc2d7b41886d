#pragma once

#include <boost/asio/ssl/context.hpp>
#include <expected>
#include <memory>
#include <string>

#include "config/cell_config.hpp"
#include "daemon/control/file_stamp.hpp"
#include "proto/control/certificate.hpp"

namespace truepose::daemon {

/// By what clients over TLS know the daemon: TLS 1.3 with its certificate and key, read again when the files
/// have changed. Clients are asked for a certificate and need none.
class TlsIdentity {
 public:
  /// The error is one sentence: a file that is missing, readable by others or of another key.
  static std::expected<TlsIdentity, std::string> load(const config::TlsConfig& files);

  /// Looks at the files, and reads them where they are others than when they were read last.
  /// @return whether they were; or one sentence why they cannot be used, once: what was known before stays
  std::expected<bool, std::string> refresh();

  /// Of connections from now on.
  const std::shared_ptr<boost::asio::ssl::context>& context() const { return context_; }
  const control::Certificate& certificate() const { return certificate_; }

 private:
  explicit TlsIdentity(config::TlsConfig files) : files_{std::move(files)} {}

  config::TlsConfig files_;
  FileStamp certificate_stamp_{}, key_stamp_{};  ///< as they were read last
  std::string complaint_;                        ///< why they could not be since
  std::shared_ptr<boost::asio::ssl::context> context_;
  control::Certificate certificate_;
};

}  // namespace truepose::daemon
