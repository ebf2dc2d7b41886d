#include "proto/control/session_proof.hpp"

#include <openssl/evp.h>
#include <openssl/hmac.h>

#include <array>
#include <stdexcept>

#include "proto/text/digest.hpp"

namespace truepose::control {

std::string session_proof(std::string_view token, Prover prover, const SessionTerms& terms) {
  // Who proves stands in it: what one end said is no answer for the other. No part has a newline.
  const std::string text = std::string{"truepose session 1\n"} +
                           (prover == Prover::Client ? "client\n" : "server\n") + terms.endpoint + "\n" +
                           terms.client_nonce + "\n" + terms.server_nonce + "\n";
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  const auto* const bytes = reinterpret_cast<const unsigned char*>(text.data());
  if (HMAC(EVP_sha256(), token.data(), static_cast<int>(token.size()), bytes, text.size(), digest.data(),
           &size) == nullptr)
    throw std::runtime_error{"no HMAC-SHA256 in this machine's libcrypto"};
  return text::hexadecimal({digest.data(), size});
}

std::string new_nonce(const RandomBytes& random) { return random_hex(16, random); }

bool is_nonce(std::string_view text) {
  return text.size() == 32 && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

}  // namespace truepose::control
