#include "daemon/control/tls_identity.hpp"

#include <openssl/ssl.h>

#include <tuple>
#include <utility>

#include "config/text_file.hpp"
#include "daemon/control/private_file.hpp"

namespace truepose::daemon {

namespace {

namespace asio = boost::asio;
namespace ssl = asio::ssl;

std::shared_ptr<ssl::context> new_context() {
  auto context = std::make_shared<ssl::context>(ssl::context::tls_server);
  SSL_CTX_set_min_proto_version(context->native_handle(), TLS1_3_VERSION);
  // A session that is taken up again would show no certificate.
  SSL_CTX_set_num_tickets(context->native_handle(), 0);
  SSL_CTX_set_session_cache_mode(context->native_handle(), SSL_SESS_CACHE_OFF);
  // TLS sees that the certificate is the client's own; who that is, the access list says by its fingerprint.
  context->set_verify_mode(ssl::verify_peer);
  context->set_verify_callback([](bool, ssl::verify_context&) { return true; });
  return context;
}

/// Reads both files. Throws ConfigError.
std::pair<std::shared_ptr<ssl::context>, control::Certificate> read(const config::TlsConfig& files) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 18U;
  const auto bad = [](const std::filesystem::path& file, const std::string& why) {
    return config::ConfigError{file.string() + ": " + why};
  };
  const std::string chain = config::read_text_file(files.certificate, kMostBytes);
  auto certificate = control::read_certificate(chain);
  if (!certificate) throw bad(files.certificate, certificate.error());
  const auto key = read_private_file(files.key, kMostBytes);
  if (!key) throw bad(files.key, key.error());

  auto context = new_context();
  boost::system::error_code error;
  context->use_certificate_chain(asio::buffer(chain), error);
  if (error) throw bad(files.certificate, "cannot be used: " + error.message());
  context->use_private_key(asio::buffer(*key), ssl::context::pem, error);
  if (error) throw bad(files.key, "is not the private key of " + files.certificate.string());
  return {std::move(context), *std::move(certificate)};
}

}  // namespace

std::expected<TlsIdentity, std::string> TlsIdentity::load(const config::TlsConfig& files) {
  TlsIdentity identity{files};
  if (const auto read = identity.refresh(); !read) return std::unexpected(read.error());
  return identity;
}

std::expected<bool, std::string> TlsIdentity::refresh() {
  const FileStamp certificate_stamp = stamp_of(files_.certificate), key_stamp = stamp_of(files_.key);
  if (context_ && certificate_stamp == certificate_stamp_ && key_stamp == key_stamp_) return false;
  try {
    std::tie(context_, certificate_) = read(files_);
  } catch (const config::ConfigError& error) {
    // A failure may pass while the files stay the same: they are read again, and it is reported once.
    if (std::exchange(complaint_, error.what()) == error.what()) return false;
    return std::unexpected("control.tls: " + std::string{error.what()} +
                           "; `truepose tls init` makes both files");
  }
  certificate_stamp_ = certificate_stamp;
  key_stamp_ = key_stamp;
  complaint_.clear();
  return true;
}

}  // namespace truepose::daemon
