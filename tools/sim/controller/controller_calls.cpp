// The part of Controller that carries out what programs call: messages, Ethernet KRL and RSI.
#include <boost/algorithm/string/predicate.hpp>

#include "proto/text/device_text.hpp"
#include "tools/sim/controller/controller.hpp"

namespace truepose::sim {
namespace {

using krl::CallResult;
using krl::Parts;
using krl::Value;

// Numbers of Ethernet KRL's messages.
constexpr int kNoError = 0, kFileFault = 3, kNoValue = 17, kNotUsable = 512;

constexpr int kRsiOk = 0, kRsiFault = -1;
constexpr std::string_view kGet = "EKI_GET", kSet = "EKI_SET";

std::string text_in(const krl::ExternalCall& call, std::size_t argument) {
  return krl::text_of(call.arguments[argument]);
}

EkiFile::Type type_in(std::string_view name) {
  if (name == "INT") return EkiFile::Type::Int;
  if (name == "REAL") return EkiFile::Type::Real;
  if (name == "FRAME") return EkiFile::Type::Frame;
  return name == "BOOL" ? EkiFile::Type::Bool : EkiFile::Type::String;
}

/// Puts a value where the program wants it.
bool give(Value& place, Value value) {
  const auto* const text = std::get_if<std::string>(&value);
  if (text == nullptr) {
    place = std::move(value);
    return true;
  }
  const std::size_t size = std::get<std::string>(place).size();
  if (text->size() > size) return false;
  place = *text + std::string(size - text->size(), '\0');
  return true;
}

/// What a program gives: characters without those that were not set.
Value given(const Value& argument) {
  return std::holds_alternative<std::string>(argument) ? Value{krl::text_of(argument)} : argument;
}

}  // namespace

std::expected<CallResult, std::string> Controller::call(krl::ExternalCall& call) {
  if (call.name == "MSGNOTIFY") {
    show({.text = text_in(call, 0)});
    return CallResult{};
  }
  if (call.name.ends_with("_KRLMSG") || call.name.ends_with("_KRLDLG")) return message(call);
  if (call.name == "ERR_CLEAR") {
    call.arguments[0] = no_error();
    return CallResult{};
  }
  if (call.name == "ERR_RAISE") return std::unexpected("the program raises an error");
  if (call.name.starts_with("EKI_")) return eki(call);
  return rsi_call(call);
}

/// KrlMsg: what is set is shown at once. A dialog is answered by its first key.
std::expected<CallResult, std::string> Controller::message(krl::ExternalCall& call) {
  constexpr int kHandle = 1, kFirstKey = 1;
  if (call.name.starts_with("SET_")) {
    const auto& message = std::get<Parts>(call.arguments[call.name == "SET_KRLMSG" ? 1 : 0]);
    show({.text = krl::text_of(message[0]) + ": " + krl::text_of(message[2])});
    return CallResult{.value = kHandle};
  }
  if (call.name == "EXISTS_KRLDLG") call.arguments[1] = kFirstKey;
  return CallResult{.value = call.name == "CLEAR_KRLMSG"};
}

// ---- Ethernet KRL

std::expected<CallResult, std::string> Controller::eki(krl::ExternalCall& call) {
  const auto found = channels_.find(text_in(call, 0));
  if (found == channels_.end()) return eki_status(nullptr, {}, kFileFault);
  EkiChannel& channel = found->second;
  if (call.name == "EKI_INIT") {
    channel.init();
    return eki_status(&channel, {}, kNoError);
  }
  if (call.name == "EKI_CLEAR") {
    drop(channel);
    return eki_status(&channel, {}, kNoError);
  }
  if (call.name == "EKI_OPEN") return eki_status(&channel, {}, channel.open() ? kNoError : kNotUsable);
  if (!channel.is_initialised()) return eki_status(&channel, {}, kNotUsable);
  return eki_element(call, channel);
}

std::expected<CallResult, std::string> Controller::eki_element(krl::ExternalCall& call, EkiChannel& channel) {
  const std::string element = text_in(call, 1);
  if (call.name == "EKI_CHECKBUFFER") return eki_status(&channel, element, kNoError);
  if (call.name == "EKI_CLEARBUFFER") {
    channel.clear_buffer(element);
    return eki_status(&channel, element, kNoError);
  }
  if (call.name == "EKI_SEND") {
    const auto document = channel.document(element);
    if (!document) return std::unexpected(text_in(call, 0) + ": " + document.error());
    if (!channel.is_connected()) return eki_status(&channel, {}, kNotUsable);
    documents_.push_back({text_in(call, 0), *document});
    return eki_status(&channel, {}, kNoError);
  }
  if (call.name.starts_with(kSet)) {
    if (const auto set = channel.set(element, given(call.arguments[2])); !set)
      return std::unexpected(text_in(call, 0) + ": " + set.error());
    return eki_status(&channel, {}, kNoError);
  }
  auto value = channel.take(element, type_in(call.name.substr(kGet.size())));
  if (!value || !give(call.arguments[2], *std::move(value))) return eki_status(&channel, element, kNoValue);
  return eki_status(&channel, element, kNoError);
}

CallResult Controller::eki_status(const EkiChannel* channel, std::string_view element, int error) const {
  const int left = channel == nullptr ? 0 : static_cast<int>(channel->waiting(element));
  const bool connected = channel != nullptr && channel->is_connected();
  return {.value = Parts{left, 0, error, connected, 0}};
}

// ---- RSI

std::expected<CallResult, std::string> Controller::rsi_call(krl::ExternalCall& call) {
  if (call.name == "RSI_MOVECORR") return CallResult{.is_finished = movecorr(call.is_first)};
  if (call.name == "RSI_CREATE") return CallResult{.value = rsi_create(call)};
  if (call.name == "RSI_SETPUBLICPAR" || call.name == "RSI_GETPUBLICPAR") return rsi_parameter(call);
  if (call.name == "RSI_ON") {
    if (!rsi_context_ || rsi_on_) return CallResult{.value = kRsiFault};
    const auto* cycle = std::get_if<krl::Literal>(&call.arguments[1]);
    rsi_relative_ = std::get<krl::Literal>(call.arguments[0]).name == "RELATIVE";
    rsi_ipo_ = cycle != nullptr && cycle->name == "IPO";
    rsi_on_ = true;
    ++rsi_sessions_;
    return CallResult{.value = kRsiOk};
  }
  const bool was_on = rsi_on_, was_created = rsi_context_.has_value();
  close_rsi();
  if (call.name == "RSI_OFF") return CallResult{.value = was_on ? kRsiOk : kRsiFault};
  rsi_context_.reset();
  const bool good = call.name == "RSI_RESET" || was_created;
  return CallResult{.value = good ? kRsiOk : kRsiFault};
}

int Controller::rsi_create(krl::ExternalCall& call) {
  const std::string name = text_in(call, 0);
  if (rsi_context_) return kRsiFault;
  if (std::ranges::find(setup_.contexts, name) == setup_.contexts.end()) {
    messages_.push_back("RSI_CREATE: File not found: " + text::device_text(name));
    return kRsiFault;
  }
  rsi_context_ = name;
  rsi_parameters_.clear();
  call.arguments[1] = 1;
  return kRsiOk;
}

/// Sets or reads a parameter of the context that was created.
std::expected<CallResult, std::string> Controller::rsi_parameter(krl::ExternalCall& call) {
  RsiParameter parameter{text_in(call, 1), text_in(call, 2)};
  if (!rsi_context_) return CallResult{.value = kRsiFault};
  std::optional<double> value = setup_.rsi_parameter(*rsi_context_, parameter);
  if (!value) return CallResult{.value = kRsiFault};
  if (call.name == "RSI_SETPUBLICPAR") {
    if (rsi_on_) return std::unexpected("RSI_SETPUBLICPAR while RSI is on is not simulated");
    const auto* whole = std::get_if<std::int32_t>(&call.arguments[3]);
    parameter.value = whole != nullptr ? *whole : std::get<double>(call.arguments[3]);
    rsi_parameters_.push_back(std::move(parameter));
    return CallResult{.value = kRsiOk};
  }
  for (const RsiParameter& set : rsi_parameters_) {
    const bool same = boost::algorithm::iequals(set.object, parameter.object) &&
                      boost::algorithm::iequals(set.parameter, parameter.parameter);
    if (same) value = set.value;
  }
  call.arguments[3] = *value;
  return CallResult{.value = kRsiOk};
}

/// The arm stands, but for the corrections, until STOP. @return whether the program continues
bool Controller::movecorr(bool is_first) {
  if (is_first && rsi_on_) {
    in_movecorr_ = true;
    if (!setup_.stream_path.empty()) {
      std::vector<JointVector> points{motion_.position()};
      points.insert(points.end(), setup_.stream_path.begin(), setup_.stream_path.end());
      constexpr double kSpeed = 0.2;                   // share of the greatest
      constexpr std::chrono::milliseconds kRest{500};  // no arm moves in the cycle that opens RSI
      stream_begins_ = time_ + kRest;
      stream_path_.emplace(setup_.nominal, std::move(points), kSpeed);
    }
  }
  return !in_movecorr_;
}

void Controller::close_rsi() {
  if (!std::exchange(rsi_on_, false)) return;
  in_movecorr_ = false;
  stream_path_.reset();
  motion_.place(actual_);
}

}  // namespace truepose::sim
