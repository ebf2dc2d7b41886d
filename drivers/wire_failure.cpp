#include "drivers/wire_failure.hpp"

#include <algorithm>
#include <boost/asio/error.hpp>
#include <charconv>

namespace truepose::drivers {

namespace asio = boost::asio;
using boost::system::error_category;
using boost::system::error_code;

namespace {

/// That a stream's errors are of.
std::array<const error_category*, 4> categories() {
  return {&asio::error::get_system_category(), &asio::error::get_misc_category(),
          &asio::error::get_netdb_category(), &asio::error::get_addrinfo_category()};
}

std::string_view take_word(std::string_view& text, char end) {
  const std::string_view word = text.substr(0, text.find(end));
  text.remove_prefix(std::min(word.size() + 1, text.size()));
  return word;
}

}  // namespace

std::string text(const WireFailure& failure) {
  return std::string{name_of(kWireOperations, failure.operation)} + ' ' + failure.error.category().name() +
         ':' + std::to_string(failure.error.value()) + ' ' + failure.error.message();
}

std::expected<WireFailure, std::string> read_failure(std::string_view text) {
  const std::string_view operation = take_word(text, ' '), category = take_word(text, ':'),
                         number = take_word(text, ' ');
  const auto operations = names_of(kWireOperations);
  if (std::ranges::find(operations, operation) == operations.end())
    return std::unexpected("an operation that is none: \"" + std::string{operation} + "\"");
  const auto known = categories();
  const auto of = std::ranges::find(known, category, [](const auto* each) { return each->name(); });
  int value = 0;
  const auto [rest, fault] = std::from_chars(number.data(), number.data() + number.size(), value);
  if (of == known.end() || fault != std::errc{} || rest != number.data() + number.size())
    return std::unexpected("an error that is unknown: \"" + std::string{category} + ":" +
                           std::string{number} + "\"");
  return WireFailure{value_of(kWireOperations, operation), error_code{value, **of}};
}

void tell_failure(const WireTap& tap, WireOperation operation, const error_code& error) {
  if (!error || (error == asio::error::operation_aborted && operation != WireOperation::Write)) return;
  tap(recording::Kind::Failed, text(WireFailure{operation, error}));
}

}  // namespace truepose::drivers
