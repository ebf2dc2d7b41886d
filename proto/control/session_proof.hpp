#pragma once

#include <string>
#include <string_view>

#include "proto/text/random_bytes.hpp"

namespace truepose::control {

/// What both ends of a session have agreed on before one proves to the other that it knows the token.
struct SessionTerms {
  std::string endpoint;      ///< "127.0.0.1 7210", where the daemon listens: a proof is good there alone
  std::string client_nonce;  ///< 16 bytes that never came before, in hexadecimal digits
  std::string server_nonce;
};

enum class Prover { Client, Server };

/// Proves that its maker knows the token, without telling it: HMAC-SHA256 of the terms and of who proves, in
/// hexadecimal digits. From a weak token it can be guessed at leisure, so a token is random.
std::string session_proof(std::string_view token, Prover prover, const SessionTerms& terms);

std::string new_nonce(const RandomBytes& random);
/// Whether a text from the other end can be a nonce.
bool is_nonce(std::string_view text);

}  // namespace truepose::control
