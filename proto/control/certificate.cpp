#include "proto/control/certificate.hpp"

#include <openssl/bio.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <array>
#include <ctime>
#include <memory>
#include <stdexcept>

#include "proto/control/json_text.hpp"
#include "proto/text/device_text.hpp"
#include "proto/text/digest.hpp"

namespace truepose::control {

namespace {

std::chrono::sys_seconds time_of(const ASN1_TIME* time) {
  std::tm utc{};
  if (ASN1_TIME_to_tm(time, &utc) != 1) throw std::runtime_error{"a certificate without a time"};
  return std::chrono::sys_seconds{std::chrono::seconds{::timegm(&utc)}};
}

std::string common_name(const x509_st& certificate) {
  const X509_NAME* const subject = X509_get_subject_name(&certificate);
  const int at = X509_NAME_get_index_by_NID(subject, NID_commonName, -1);
  unsigned char* utf8 = nullptr;
  const int size =
      at < 0 ? -1 : ASN1_STRING_to_UTF8(&utf8, X509_NAME_ENTRY_get_data(X509_NAME_get_entry(subject, at)));
  if (size < 0) return {};
  const std::string name{reinterpret_cast<const char*>(utf8), static_cast<std::size_t>(size)};
  OPENSSL_free(utf8);
  return text::device_text(name);
}

}  // namespace

Certificate facts_of(const x509_st& certificate) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  if (X509_digest(&certificate, EVP_sha256(), digest.data(), &size) != 1)
    throw std::runtime_error{"a certificate without a digest"};
  return {text::hexadecimal({digest.data(), size}), common_name(certificate),
          time_of(X509_get0_notBefore(&certificate)), time_of(X509_get0_notAfter(&certificate))};
}

std::expected<Certificate, std::string> read_certificate(std::string_view pem) {
  const std::unique_ptr<BIO, decltype(&BIO_free)> bytes{
      BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())), &BIO_free};
  const std::unique_ptr<X509, decltype(&X509_free)> certificate{
      PEM_read_bio_X509(bytes.get(), nullptr, nullptr, nullptr), &X509_free};
  if (!certificate) return std::unexpected("holds no certificate in PEM form");
  return facts_of(*certificate);
}

std::string validity_fault(const Certificate& certificate, std::chrono::system_clock::time_point now) {
  const auto second = std::chrono::floor<std::chrono::seconds>(now);
  if (second < certificate.from) return "is not valid before " + rfc3339(certificate.from);
  if (second > certificate.until) return "expired on " + rfc3339(certificate.until);
  return {};
}

}  // namespace truepose::control
