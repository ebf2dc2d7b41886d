#pragma once

#include <openssl/evp.h>
#include <openssl/x509.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "tools/truepose/c_deleter.hpp"

namespace truepose::tools {

using PrivateKey = std::unique_ptr<EVP_PKEY, CDeleter<&EVP_PKEY_free>>;
using X509Certificate = std::unique_ptr<X509, CDeleter<&X509_free>>;

/// A certificate and the private key of it.
struct Identity {
  X509Certificate certificate;
  PrivateKey key;
};

/// Whom a certificate is for, and for what.
struct CertificateTerms {
  std::string name;                ///< common name
  std::vector<std::string> hosts;  ///< of a daemon: names and IP addresses by which it is called
  std::string usage;               ///< "serverAuth" or "clientAuth"
  std::chrono::days valid;
};

/// A self-signed CA. Keys are on the curve P-256, signatures ECDSA with SHA-256. Each throws
/// std::runtime_error with OpenSSL's words.
Identity new_authority(const std::string& name, std::chrono::days valid);
/// A certificate of a CA.
Identity new_identity(const CertificateTerms& terms, const Identity& authority);

std::string pem_of(const X509& certificate);
std::string pem_of(const EVP_PKEY& key);
/// Null where the text holds none.
X509Certificate certificate_in(const std::string& pem);
PrivateKey key_in(const std::string& pem);

}  // namespace truepose::tools
