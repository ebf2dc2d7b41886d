#include "core/data/measured_time.hpp"

#include <charconv>
#include <chrono>
#include <cmath>

namespace truepose {
namespace {

constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Takes a text apart from its front. What is missing is remembered, so that a whole form is read through.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : left_{text} {}

  bool is_at(std::string_view any) const { return !left_.empty() && any.find(left_[0]) != any.npos; }
  bool take_if(std::string_view any) {
    const bool there = is_at(any);
    if (there) left_.remove_prefix(1);
    return there;
  }
  void take(std::string_view any) { well_ = take_if(any) && well_; }

  /// So many digits, of a number between both.
  int number(std::size_t digits, int least, int most) {
    int value = 0;
    for (std::size_t i = 0; i < digits; ++i) {
      if (left_.empty() || !is_digit(left_[0])) {
        well_ = false;
        return least;
      }
      value = 10 * value + (left_[0] - '0');
      left_.remove_prefix(1);
    }
    well_ = well_ && value >= least && value <= most;
    return value;
  }

  /// The digits behind a decimal point, if there is one.
  double fraction() {
    double value = 0, unit = 1;
    if (!take_if(".")) return value;
    well_ = well_ && is_at("0123456789");
    for (; is_at("0123456789"); left_.remove_prefix(1)) value += (unit /= 10) * (left_[0] - '0');
    return value;
  }

  bool ended_well() const { return well_ && left_.empty(); }

 private:
  std::string_view left_;
  bool well_ = true;
};

std::optional<double> number_of_seconds(std::string_view text) {
  double seconds = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  // Written so that a NaN is refused as well.
  if (error != std::errc{} || end != text.data() + text.size() || !(std::abs(seconds) <= kMostSeconds))
    return std::nullopt;
  return seconds;
}

}  // namespace

std::optional<MeasuredTime> measured_time(std::string_view text) {
  if (const auto seconds = number_of_seconds(text)) return MeasuredTime{TimeForm::Number, *seconds};
  Scanner scanner{text};
  const int year = scanner.number(4, 0, 9999);
  scanner.take("-");
  const auto month = static_cast<unsigned>(scanner.number(2, 1, 12));
  scanner.take("-");
  const auto day = static_cast<unsigned>(scanner.number(2, 1, 31));
  scanner.take("Tt ");
  const int hour = scanner.number(2, 0, 23);
  scanner.take(":");
  const int minute = scanner.number(2, 0, 59);
  scanner.take(":");
  const double second = scanner.number(2, 0, 60) + scanner.fraction();

  TimeForm form = TimeForm::Local;
  int east_minutes = 0;
  if (scanner.is_at("+-")) {
    const int sign = scanner.take_if("-") ? -1 : 1;
    scanner.take_if("+");
    const int hours = scanner.number(2, 0, 23);
    scanner.take_if(":");
    east_minutes = sign * (60 * hours + scanner.number(2, 0, 59));
    form = TimeForm::Zoned;
  } else if (scanner.take_if("Zz")) {
    form = TimeForm::Zoned;
  }
  const std::chrono::year_month_day date{std::chrono::year{year}, std::chrono::month{month},
                                         std::chrono::day{day}};
  if (!scanner.ended_well() || !date.ok()) return std::nullopt;
  const auto days = static_cast<double>(std::chrono::sys_days{date}.time_since_epoch().count());
  return MeasuredTime{form, 86400 * days + 60 * (60 * hour + minute - east_minutes) + second};
}

}  // namespace truepose
