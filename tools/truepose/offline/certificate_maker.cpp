#include "tools/truepose/offline/certificate_maker.hpp"

#include <arpa/inet.h>
#include <openssl/bn.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>

#include <array>
#include <stdexcept>
#include <utility>

namespace truepose::tools {

namespace {

using Bio = std::unique_ptr<BIO, CDeleter<&BIO_free>>;

void expect(bool done) {
  if (done) return;
  const char* const words = ERR_reason_error_string(ERR_get_error());
  throw std::runtime_error{std::string{"OpenSSL: "} + (words ? words : "failed")};
}

/// @param value  as in a configuration of OpenSSL
void add_extension(X509& certificate, X509& issuer, int kind, const std::string& value) {
  X509V3_CTX context{};
  X509V3_set_ctx(&context, &issuer, &certificate, nullptr, nullptr, 0);
  const std::unique_ptr<X509_EXTENSION, CDeleter<&X509_EXTENSION_free>> extension{
      X509V3_EXT_conf_nid(nullptr, &context, kind, value.c_str())};
  expect(extension && X509_add_ext(&certificate, extension.get(), -1) == 1);
}

/// "IP:10.0.0.2,DNS:cell.plant"
std::string alternative_names(const std::vector<std::string>& hosts) {
  std::string names;
  for (const std::string& host : hosts) {
    std::array<unsigned char, sizeof(in6_addr)> address{};
    const bool is_ip = ::inet_pton(AF_INET, host.c_str(), address.data()) == 1 ||
                       ::inet_pton(AF_INET6, host.c_str(), address.data()) == 1;
    names += (names.empty() ? "" : ",") + std::string{is_ip ? "IP:" : "DNS:"} + host;
  }
  return names;
}

void set_random_serial(X509& certificate) {
  constexpr int kBits = 127;
  const std::unique_ptr<BIGNUM, CDeleter<&BN_free>> number{BN_new()};
  expect(BN_rand(number.get(), kBits, BN_RAND_TOP_ONE, BN_RAND_BOTTOM_ANY) == 1 &&
         BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(&certificate)) != nullptr);
}

/// A certificate for a key, but for its issuer, its extensions and the signature.
X509Certificate unsigned_certificate(const std::string& name, EVP_PKEY& key, std::chrono::days valid) {
  X509Certificate certificate{X509_new()};
  expect(X509_set_version(certificate.get(), X509_VERSION_3) == 1);
  set_random_serial(*certificate);
  // A clock that is an hour behind shall take it too.
  const std::chrono::seconds until = valid, from = -std::chrono::hours{1};
  expect(X509_gmtime_adj(X509_getm_notBefore(certificate.get()), from.count()) != nullptr &&
         X509_gmtime_adj(X509_getm_notAfter(certificate.get()), until.count()) != nullptr);
  expect(X509_NAME_add_entry_by_NID(X509_get_subject_name(certificate.get()), NID_commonName, MBSTRING_UTF8,
                                    reinterpret_cast<const unsigned char*>(name.data()),
                                    static_cast<int>(name.size()), -1, 0) == 1);
  expect(X509_set_pubkey(certificate.get(), &key) == 1);
  return certificate;
}

void sign(X509& certificate, const X509& issuer, EVP_PKEY& key) {
  expect(X509_set_issuer_name(&certificate, X509_get_subject_name(&issuer)) == 1);
  expect(X509_sign(&certificate, &key, EVP_sha256()) > 0);
}

std::string text_in(BIO& bytes) {
  char* text = nullptr;
  const long size = BIO_get_mem_data(&bytes, &text);
  return {text, static_cast<std::size_t>(size)};
}

Bio bytes_of(const std::string& text) {
  return Bio{BIO_new_mem_buf(text.data(), static_cast<int>(text.size()))};
}

}  // namespace

Identity new_authority(const std::string& name, std::chrono::days valid) {
  PrivateKey key{EVP_EC_gen("P-256")};
  expect(key != nullptr);
  X509Certificate certificate = unsigned_certificate(name, *key, valid);
  add_extension(*certificate, *certificate, NID_basic_constraints, "critical,CA:TRUE,pathlen:0");
  add_extension(*certificate, *certificate, NID_key_usage, "critical,keyCertSign,cRLSign");
  add_extension(*certificate, *certificate, NID_subject_key_identifier, "hash");
  sign(*certificate, *certificate, *key);
  return {std::move(certificate), std::move(key)};
}

Identity new_identity(const CertificateTerms& terms, const Identity& authority) {
  PrivateKey key{EVP_EC_gen("P-256")};
  expect(key != nullptr);
  X509Certificate certificate = unsigned_certificate(terms.name, *key, terms.valid);
  X509& issuer = *authority.certificate;
  add_extension(*certificate, issuer, NID_basic_constraints, "critical,CA:FALSE");
  add_extension(*certificate, issuer, NID_key_usage, "critical,digitalSignature");
  add_extension(*certificate, issuer, NID_ext_key_usage, terms.usage);
  if (!terms.hosts.empty())
    add_extension(*certificate, issuer, NID_subject_alt_name, alternative_names(terms.hosts));
  add_extension(*certificate, issuer, NID_subject_key_identifier, "hash");
  add_extension(*certificate, issuer, NID_authority_key_identifier, "keyid:always");
  sign(*certificate, issuer, *authority.key);
  return {std::move(certificate), std::move(key)};
}

std::string pem_of(const X509& certificate) {
  const Bio bytes{BIO_new(BIO_s_mem())};
  expect(PEM_write_bio_X509(bytes.get(), &certificate) == 1);
  return text_in(*bytes);
}

std::string pem_of(const EVP_PKEY& key) {
  const Bio bytes{BIO_new(BIO_s_mem())};
  expect(PEM_write_bio_PKCS8PrivateKey(bytes.get(), &key, nullptr, nullptr, 0, nullptr, nullptr) == 1);
  return text_in(*bytes);
}

X509Certificate certificate_in(const std::string& pem) {
  return X509Certificate{PEM_read_bio_X509(bytes_of(pem).get(), nullptr, nullptr, nullptr)};
}

PrivateKey key_in(const std::string& pem) {
  return PrivateKey{PEM_read_bio_PrivateKey(bytes_of(pem).get(), nullptr, nullptr, nullptr)};
}

}  // namespace truepose::tools
