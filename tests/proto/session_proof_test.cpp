#include "proto/control/session_proof.hpp"

#include <gtest/gtest.h>

#include <set>

namespace truepose::control {
namespace {

const SessionTerms kTerms{"127.0.0.1 7210", "00112233445566778899aabbccddeeff",
                          "ffeeddccbbaa99887766554433221100"};
constexpr std::string_view kToken = "0123456789abcdef0123456789abcdef";

// As Python makes it: hmac.new(token, text, "sha256").hexdigest().
TEST(SessionProof, IsTheHmacOfTheTermsThatEveryLanguageCanMake) {
  EXPECT_EQ(session_proof(kToken, Prover::Client, kTerms),
            "4941cd269accac12cc8d0566d3425f4f05b7094f54a277afcb9fcac66a23c3e1");
  EXPECT_EQ(session_proof(kToken, Prover::Server, kTerms),
            "1dd348e56ac946d897403975b5b595c484a4faff4d054dde4635fc15d81ca6fe");
}

TEST(SessionProof, IsAnotherForAnyOtherTokenEndOrTerm) {
  const auto with = [](auto change) {
    SessionTerms terms = kTerms;
    change(terms);
    return session_proof(kToken, Prover::Client, terms);
  };
  const std::set<std::string> all{session_proof(kToken, Prover::Client, kTerms),
                                  session_proof(kToken, Prover::Server, kTerms),
                                  session_proof("another token", Prover::Client, kTerms),
                                  with([](SessionTerms& terms) { terms.endpoint = "127.0.0.1 7211"; }),
                                  with([](SessionTerms& terms) { terms.client_nonce[0] = '1'; }),
                                  with([](SessionTerms& terms) { terms.server_nonce[0] = '1'; })};
  EXPECT_EQ(all.size(), 6U);
}

TEST(SessionProof, HasANewNonceEachTime) {
  const std::string nonce = new_nonce(kernel_random);
  EXPECT_EQ(nonce.size(), 32U);
  EXPECT_NE(new_nonce(kernel_random), nonce);
}

}  // namespace
}  // namespace truepose::control
