#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "tools/truepose/c_deleter.hpp"
#include "tools/truepose/online/channel.hpp"

namespace truepose::tools {

namespace {

using SslContext = std::unique_ptr<SSL_CTX, CDeleter<&SSL_CTX_free>>;
using Ssl = std::unique_ptr<SSL, CDeleter<&SSL_free>>;

/// OpenSSL's socket, but that writing to a daemon that is gone ends with an error, not with SIGPIPE.
const BIO_METHOD* quiet_socket() {
  static const BIO_METHOD* const kMethod = [] {
    const BIO_METHOD* const usual = BIO_s_socket();
    BIO_METHOD* const method = BIO_meth_new(BIO_TYPE_SOCKET, "quiet socket");
    BIO_meth_set_read(method, BIO_meth_get_read(usual));
    BIO_meth_set_ctrl(method, BIO_meth_get_ctrl(usual));
    BIO_meth_set_create(method, BIO_meth_get_create(usual));
    BIO_meth_set_destroy(method, BIO_meth_get_destroy(usual));
    BIO_meth_set_write(method, [](BIO* bio, const char* bytes, int size) {
      int socket = -1;
      BIO_get_fd(bio, &socket);
      const auto sent = static_cast<int>(::send(socket, bytes, static_cast<std::size_t>(size), MSG_NOSIGNAL));
      BIO_clear_retry_flags(bio);
      if (sent <= 0 && BIO_sock_should_retry(sent) != 0) BIO_set_retry_write(bio);
      return sent;
    });
    return method;
  }();
  return kMethod;
}

std::string openssl_words() {
  const unsigned long error = ::ERR_peek_last_error();
  const char* const words = ::ERR_reason_error_string(error);
  ::ERR_clear_error();
  return words ? words : "unknown error of TLS";
}

/// Whom the certificate has to name.
bool expect_host(SSL& ssl, const std::string& host) {
  X509_VERIFY_PARAM* const expected = SSL_get0_param(&ssl);
  if (X509_VERIFY_PARAM_set1_ip_asc(expected, host.c_str()) == 1) return true;
  return X509_VERIFY_PARAM_set1_host(expected, host.c_str(), host.size()) == 1;
}

class TlsChannel final : public Channel {
 public:
  TlsChannel(int socket, SslContext context, Ssl ssl)
      : socket_{socket}, context_{std::move(context)}, ssl_{std::move(ssl)} {}
  TlsChannel(const TlsChannel&) = delete;
  TlsChannel& operator=(const TlsChannel&) = delete;
  ~TlsChannel() override { SSL_shutdown(ssl_.get()); }

  /// @return why it failed
  std::optional<std::string> shake_hands(const std::string& host, Deadline until) {
    if (!expect_host(*ssl_, host)) return openssl_words();
    while (true) {
      const int done = SSL_connect(ssl_.get());
      if (done == 1) return std::nullopt;
      if (auto failed = wait_after(done, until)) return failed;
    }
  }

  std::expected<void, std::string> write(std::string_view bytes, Deadline until) override {
    while (!bytes.empty()) {
      const int size = SSL_write(ssl_.get(), bytes.data(), static_cast<int>(bytes.size()));
      if (size > 0) {
        bytes.remove_prefix(static_cast<std::size_t>(size));
      } else if (auto failed = wait_after(size, until)) {
        return std::unexpected(*failed);
      }
    }
    return {};
  }

  std::expected<std::size_t, std::string> read_some(std::span<char> bytes, Deadline until) override {
    while (true) {
      const int size = SSL_read(ssl_.get(), bytes.data(), static_cast<int>(bytes.size()));
      if (size > 0) return static_cast<std::size_t>(size);
      if (auto failed = wait_after(size, until)) return std::unexpected(*failed);
    }
  }

 private:
  /// Waits for what TLS waits for. @return why it cannot continue; none where it can
  std::optional<std::string> wait_after(int result, Deadline until) {
    const int system_error = errno;
    switch (SSL_get_error(ssl_.get(), result)) {
      case SSL_ERROR_WANT_READ:
        return wait_for(socket_, POLLIN, until) ? std::nullopt : std::optional{"no answer in time"};
      case SSL_ERROR_WANT_WRITE:
        return wait_for(socket_, POLLOUT, until) ? std::nullopt : std::optional{"it takes no more requests"};
      case SSL_ERROR_ZERO_RETURN:
        return "the daemon closed it";
      case SSL_ERROR_SYSCALL:
        return system_error == 0 ? "the daemon closed it" : std::strerror(system_error);
      default:
        return why_refused();
    }
  }
  std::string why_refused() const {
    const long verified = SSL_get_verify_result(ssl_.get());
    const std::string words = openssl_words();
    if (verified == X509_V_OK) return words;
    return "its certificate does not hold: " + std::string{X509_verify_cert_error_string(verified)};
  }

  int socket_;  ///< ssl_ closes it
  SslContext context_;
  Ssl ssl_;
};

/// @return why a file cannot be used; none where it can
std::optional<std::string> load(SSL_CTX& context, const TlsFiles& files) {
  const auto unfit = [](const char* option, const std::filesystem::path& file) {
    return std::string{option} + " " + file.string() + ": " + openssl_words();
  };
  if (SSL_CTX_load_verify_file(&context, files.ca.c_str()) != 1) return unfit("--tls-ca", files.ca);
  if (files.certificate.empty()) return std::nullopt;
  if (SSL_CTX_use_certificate_chain_file(&context, files.certificate.c_str()) != 1)
    return unfit("--cert", files.certificate);
  if (SSL_CTX_use_PrivateKey_file(&context, files.key.c_str(), SSL_FILETYPE_PEM) != 1)
    return unfit("--key", files.key);
  return std::nullopt;
}

}  // namespace

std::expected<std::unique_ptr<Channel>, CommandError> tls_channel(int socket, const std::string& host,
                                                                  const TlsFiles& files,
                                                                  Channel::Deadline until) {
  SslContext context{SSL_CTX_new(TLS_client_method())};
  SSL_CTX_set_min_proto_version(context.get(), TLS1_3_VERSION);
  SSL_CTX_set_verify(context.get(), SSL_VERIFY_PEER, nullptr);
  // A line may go out in parts, from where it then lies.
  SSL_CTX_set_mode(context.get(), SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  const auto unfit = load(*context, files);
  BIO* const bio = BIO_new(quiet_socket());
  BIO_set_fd(bio, socket, BIO_CLOSE);
  if (unfit) {
    BIO_free(bio);
    return std::unexpected(CommandError{kBadInput, *unfit});
  }
  Ssl ssl{SSL_new(context.get())};
  SSL_set_bio(ssl.get(), bio, bio);
  auto channel = std::make_unique<TlsChannel>(socket, std::move(context), std::move(ssl));
  if (auto failed = channel->shake_hands(host, until))
    return std::unexpected(CommandError{kUnreachable, "no TLS with the daemon at " + host + ": " + *failed});
  return channel;
}

}  // namespace truepose::tools
