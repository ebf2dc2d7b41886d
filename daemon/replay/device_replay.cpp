#include "daemon/replay/device_replay.hpp"

#include <span>
#include <utility>

#include "proto/bridge/messages.hpp"
#include "proto/control/line_splitter.hpp"
#include "proto/eki/document_splitter.hpp"
#include "proto/eki/messages.hpp"
#include "proto/emscon/packet_splitter.hpp"
#include "proto/emscon/packets.hpp"

namespace truepose::daemon {

using recording::Kind;
using recording::Record;
using recording::Wire;

/// Takes frames out of a stream of bytes.
class DeviceReplay::Decoder {
 public:
  virtual ~Decoder() = default;
  virtual void feed(std::string_view bytes) = 0;
  /// @return whether the next frame is understood, else why not; nothing where more bytes are needed
  virtual std::optional<std::expected<void, std::string>> next() = 0;
};

namespace {

using Understood = std::optional<std::expected<void, std::string>>;

template <typename Base>
class EkiDecoder final : public Base {
 public:
  explicit EkiDecoder(Kind kind) : kind_{kind} {}
  void feed(std::string_view bytes) override { splitter_.feed(bytes); }
  Understood next() override {
    const auto document = splitter_.next();
    if (!document) return std::unexpected(document.error());
    if (!*document) return std::nullopt;
    return kind_ == Kind::Received ? verdict(eki::decode_from_controller(**document))
                                   : verdict(eki::decode_to_controller(**document));
  }

 private:
  static Understood verdict(const auto& messages) {
    if (!messages) return std::unexpected(messages.error());
    return std::expected<void, std::string>{};
  }

  Kind kind_;
  eki::DocumentSplitter splitter_;
};

template <typename Base>
class EmsconDecoder final : public Base {
 public:
  explicit EmsconDecoder(Kind kind) : kind_{kind} {}
  void feed(std::string_view bytes) override {
    splitter_.push({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  }
  Understood next() override {
    const auto packet = splitter_.next();
    if (!packet) return std::unexpected(std::string{packet.error().what});
    if (!*packet) return std::nullopt;
    return kind_ == Kind::Received ? verdict(emscon::decode_tracker_packet(**packet))
                                   : verdict(emscon::decode_client_packet(**packet));
  }

 private:
  static Understood verdict(const auto& packet) {
    if (packet) return std::expected<void, std::string>{};
    return std::unexpected(std::string{packet.error().what} + " at byte " +
                           std::to_string(packet.error().offset));
  }

  Kind kind_;
  emscon::PacketSplitter splitter_;
};

template <typename Base>
class BridgeDecoder final : public Base {
 public:
  explicit BridgeDecoder(Kind kind) : kind_{kind} {}
  void feed(std::string_view bytes) override { lines_.push(bytes); }
  Understood next() override {
    const auto line = lines_.next();
    if (!line && lines_.overflowed()) return std::unexpected(std::string{"a line that is too long"});
    if (!line) return std::nullopt;
    if (kind_ == Kind::Received) return verdict(bridge::decode_from_bridge(*line));
    const auto request = bridge::decode_request(*line);
    if (!request) return std::unexpected(request.error().refusal.text);
    return std::expected<void, std::string>{};
  }

 private:
  static Understood verdict(const auto& message) {
    if (!message) return std::unexpected(message.error());
    return std::expected<void, std::string>{};
  }

  Kind kind_;
  control::LineSplitter lines_{bridge::kMaxLine};
};

/// Whatever the tracker speaks, as its first bytes show: emScon begins with the size of a packet, whose
/// fourth byte is zero, which JSON never has.
template <typename Base>
class TrackerDecoder final : public Base {
 public:
  explicit TrackerDecoder(Kind kind) : kind_{kind} {}
  void feed(std::string_view bytes) override {
    if (!decoder_) {
      begin_ += bytes;
      bytes = begin_;
      constexpr std::size_t kTelling = 4;
      if (bytes.size() < kTelling) return;
      if (bytes[kTelling - 1] == 0) {
        decoder_ = std::make_unique<EmsconDecoder<Base>>(kind_);
      } else {
        decoder_ = std::make_unique<BridgeDecoder<Base>>(kind_);
      }
    }
    decoder_->feed(bytes);
  }
  Understood next() override { return decoder_ ? decoder_->next() : std::nullopt; }

 private:
  Kind kind_;
  std::string begin_;
  std::unique_ptr<Base> decoder_;
};

}  // namespace

DeviceReplay::DeviceReplay(Wire wire) : report_{.wire = wire} { begin(); }
DeviceReplay::~DeviceReplay() = default;

void DeviceReplay::begin() {
  const auto decoder = [this](Kind kind) -> std::unique_ptr<Decoder> {
    if (report_.wire == Wire::Tracker) return std::make_unique<TrackerDecoder<Decoder>>(kind);
    return std::make_unique<EkiDecoder<Decoder>>(kind);
  };
  received_ = decoder(Kind::Received);
  sent_ = decoder(Kind::Sent);
  refused_.reset();
}

void DeviceReplay::take(const Record& record) {
  if (record.kind == Kind::Connected) {
    begin();
    from_its_beginning_ = true;
    ++report_.sessions;
  } else if (record.kind == Kind::Closed) {
    begin();
  } else if (record.kind == Kind::Received || record.kind == Kind::Sent) {
    decode(record);
  }
}

/// After a frame that it does not understand a driver ends the connection: where it went on, it was
/// understood.
void DeviceReplay::decode(const Record& record) {
  if (refused_) {
    if (from_its_beginning_ && !report_.regression) report_.regression = refused_;
    return;
  }
  Decoder& decoder = record.kind == Kind::Received ? *received_ : *sent_;
  decoder.feed(record.bytes);
  while (const auto understood = decoder.next()) {
    ++report_.frames;
    if (*understood) continue;
    ++report_.rejected;
    refused_ = {record.time_ns, understood->error()};
    if (!report_.first_rejected) report_.first_rejected = refused_;
    return;
  }
}

}  // namespace truepose::daemon
