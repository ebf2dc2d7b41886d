#include "daemon/control/admission.hpp"

#include <utility>

#include "config/number_text.hpp"

namespace truepose::daemon {

namespace {

Caller caller_of(const control::AccessEntry& entry) {
  return {.name = entry.name, .role = entry.role, .entry = entry};
}

}  // namespace

Admission::Known Admission::by_token(const std::string& token) const {
  if (control::same_secret(token, token_)) return Caller{control::kTokenFileName, control::Role::Admin};
  if (const control::AccessEntry* const entry = access_.entries().of_token(token)) return caller_of(*entry);
  return std::unexpected(
      "wrong token: use the content of the daemon's token file, or what `truepose access add` printed");
}

Admission::Known Admission::by_proof(const std::string& proof, const control::SessionTerms& terms) const {
  const bool asked = !terms.server_nonce.empty();
  if (!asked || !control::same_secret(proof, session_proof(token_, control::Prover::Client, terms)))
    return std::unexpected("wrong token: use the content of the daemon's token file");
  return Caller{control::kTokenFileName, control::Role::Admin};
}

Admission::Known Admission::by_certificate(const control::Certificate& shown) const {
  const std::string fault = control::validity_fault(shown, parts_.wall_clock());
  if (!fault.empty())
    return std::unexpected("the certificate of " + config::in_quotes(shown.name) + " " + fault);
  const control::AccessEntry* const entry = access_.entries().of_certificate(shown.fingerprint);
  if (entry) return caller_of(*entry);
  return std::unexpected("the access list has no client with the certificate " + shown.fingerprint +
                         "; let it in by `truepose access add NAME --certificate FILE`");
}

std::string Admission::proof(const control::SessionTerms& terms) const {
  return session_proof(token_, control::Prover::Server, terms);
}

boost::asio::awaitable<Admission::Known> Admission::judge(std::string peer, Known attempt, bool unsuspected) {
  const drivers::TimePoint now = parts_.clock.now();
  const bool suspected = failed_logins_.of(peer, now) >= limits_.hello_failures;
  if (!attempt && !suspected) failed_logins_.count(peer, now);
  if (suspected && !(unsuspected && attempt)) {
    const drivers::TimePoint then = now + limits_.hello_delay;
    co_await parts_.clock.sleep_until(then);
  }
  if (!attempt && !suspected)
    parts_.warn("control: a client (" + peer + ") was not let in: " + attempt.error());
  co_return attempt;
}

bool Admission::refresh() {
  const auto changed = access_.refresh();
  const std::string& complaint = access_.complaint();
  if (!changed) parts_.warn(changed.error());
  parts_.cell.stand(
      !complaint.empty(),
      {FaultCode::Access,
       complaint + "; who was let in before still is, and after a restart the token file alone"});
  return changed.value_or(false);
}

bool Admission::still_known(const Caller& caller) const {
  if (!caller.entry) return true;
  const control::AccessEntry* const now = access_.entries().named(caller.name);
  return now && *now == *caller.entry;
}

}  // namespace truepose::daemon
