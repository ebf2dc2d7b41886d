#include "daemon/recorder/stream_settings.hpp"

#include <array>
#include <charconv>
#include <concepts>

namespace truepose::daemon {
namespace {

template <typename Number>
std::string number_text(Number number) {
  std::array<char, 32> digits;
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr};
}

template <typename Number>
bool read_number(const std::string& text, Number& number) {
  const char* const end = text.data() + text.size();
  const auto [rest, fault] = std::from_chars(text.data(), end, number);
  return fault == std::errc{} && rest == end;
}

/// Calls `visit` with the name of each number and the number. What may be absent is an optional, or a bool
/// that is false.
template <typename Options>
void for_each_setting(Options& options, const auto& visit) {
  visit("max_step_rad", options.max_step_rad);
  visit("max_total_rad", options.max_total_rad);
  visit("limit_margin_rad", options.limit_margin_rad);
  visit("singular_below_rad", options.singular_below_rad);
  visit("ramp_cycles", options.ramp_cycles);
  visit("broken_cycles", options.broken_cycles);
  visit("following_tolerance_rad", options.following_tolerance_rad);
  visit("rejected_cycles", options.rejected_cycles);
  visit("timeout_cycles", options.timeout_cycles);
  visit("cycle_ms", options.cycle);
  visit("disarm_after_ms", options.disarm_after);
  visit("peer", options.peer);
  visit("max_fk_deviation_mm", options.max_fk_deviation_mm);
  visit("never_corrected", options.never_corrected);
}

template <typename T>
std::string setting_text(const T& value) {
  if constexpr (requires { value.count(); }) {
    return number_text(value.count());
  } else {
    return number_text(value);
  }
}

template <typename T>
bool read_setting(const std::string& text, T& value) {
  if constexpr (requires { value.count(); }) {
    typename T::rep count = 0;
    const bool good = read_number(text, count);
    value = T{count};
    return good;
  } else {
    return read_number(text, value);
  }
}

}  // namespace

std::map<std::string, std::string> settings_of(const StreamOptions& options) {
  std::map<std::string, std::string> settings;
  for_each_setting(options, [&]<typename T>(const char* name, const T& value) {
    if constexpr (requires { value.has_value(); }) {
      if (value) settings[name] = setting_text(*value);
    } else if constexpr (std::same_as<T, bool>) {
      if (value) settings[name] = "1";
    } else {
      settings[name] = setting_text(value);
    }
  });
  return settings;
}

std::expected<StreamOptions, std::string> options_of(const std::map<std::string, std::string>& settings) {
  StreamOptions options;
  std::string wrong;
  for_each_setting(options, [&]<typename T>(const char* name, T& value) {
    const auto found = settings.find(name);
    bool good = found != settings.end();
    if constexpr (requires { value.has_value(); }) {
      value.reset();
      good = !good || read_setting(found->second, value.emplace());
    } else if constexpr (std::same_as<T, bool>) {
      value = good;
      good = !value || found->second == "1";
    } else {
      good = good && read_setting(found->second, value);
    }
    if (!good && wrong.empty()) wrong = std::string{"the stream's setting "} + name + " cannot be read";
  });
  if (!wrong.empty()) return std::unexpected(wrong);
  return options;
}

}  // namespace truepose::daemon
