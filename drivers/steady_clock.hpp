#pragma once

#include "drivers/clock.hpp"

namespace truepose::drivers {

/// The machine's steady clock.
class SteadyClock final : public Clock {
 public:
  TimePoint now() const override;
  boost::asio::awaitable<void> sleep_until(TimePoint when) override;
};

}  // namespace truepose::drivers
