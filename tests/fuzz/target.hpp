#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

/// What the fuzzer throws at the readers of foreign bytes: one function a reader, in a file of its name. Each
/// takes any bytes and throws a Finding where the reader broke a promise; a crash, undefined behaviour and an
/// input that takes too long are the sanitizers' and the fuzzer's to find.
namespace truepose::fuzz {

class Finding : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

inline void expect(bool holds, const std::string& promise) {
  if (!holds) throw Finding(promise);
}

void bridge(std::string_view input);
void control(std::string_view input);
void csv(std::string_view input);
void eki(std::string_view input);
void emscon(std::string_view input);
void krl(std::string_view input);
void krl_interpreter(std::string_view input);
void recording(std::string_view input);
void rsi_config(std::string_view input);
void rsi_context(std::string_view input);
void rsi_frame(std::string_view input);
void yaml(std::string_view input);

}  // namespace truepose::fuzz
