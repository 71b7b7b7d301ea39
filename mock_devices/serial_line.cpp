#include "mock_devices/serial_line.h"

#include <unistd.h>

#include <algorithm>
#include <array>

#include "mock_devices/random.h"

namespace sixdial::mock_devices {
namespace {

constexpr double kLate_s = 1.0;  // unless the order says otherwise
constexpr double kHungUp_s = 0.5;
constexpr std::size_t kMostIn = 4096;
constexpr std::size_t kCut = 4;  // characters that a truncated reply lacks
// Characters closer together than this go out in one write.
constexpr std::chrono::microseconds kTogether{200};

SerialLine::Clock::duration wall(double seconds) {
  return std::chrono::duration_cast<SerialLine::Clock::duration>(
      std::chrono::duration<double>(seconds));
}

}  // namespace

SerialLine::SerialLine(
    const Dialect& dialect, std::size_t dial, std::unique_ptr<Panel> panel,
    std::filesystem::path link, double speed, std::uint64_t seed)
    : dialect_(dialect),
      dial_(dial),
      panel_(std::move(panel)),
      link_(std::move(link)),
      speed_(speed),
      seed_(seed),
      terminal_(std::in_place, link_) {}

void SerialLine::hang_up() {
  terminal_.reset();
  in_.clear();
  out_.clear();
}

std::vector<std::size_t> SerialLine::own_dials() const {
  if (!dialect_.shared) return {dial_};
  std::vector<std::size_t> all(panel_->dial_count());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  return all;
}

void SerialLine::read_and_answer() {
  std::array<char, 512> chunk{};
  const Clock::time_point now = Clock::now();
  const ssize_t n = ::read(descriptor(), chunk.data(), chunk.size());
  if (n <= 0) return;
  if (dialect_.longest_gap_s > 0.0 && now - last_in_ > wall(dialect_.longest_gap_s))
    in_.clear();
  last_in_ = now;
  in_.append(chunk.data(), static_cast<std::size_t>(n));
  while (const auto request = dialect_.take_request(in_)) answer(*request);
  if (in_.size() > kMostIn) in_.clear();
}

void SerialLine::answer(const std::string& request) {
  Reply reply = dialect_.answer(request, dial_, *panel_);
  Clock::duration after = wall(dialect_.latency_s / speed_);
  const std::vector<std::size_t> dials =
      reply.all_dials ? own_dials() : std::vector<std::size_t>{reply.dial};
  for (const std::size_t dial : dials) {
    if (panel_->take(dial, Fault::kSilent)) reply.bytes.clear();
    if (const auto late = panel_->take(dial, Fault::kLate)) {
      after += wall(late->amount.value_or(kLate_s));
    }
    if (panel_->take(dial, Fault::kTruncated)) {
      reply.bytes.resize(reply.bytes.size() - std::min(kCut, reply.bytes.size()));
    }
    if (!reply.bytes.empty() && panel_->take(dial, Fault::kNoiseByte)) {
      const Random random(seed_, Stream::kNoiseByte, static_cast<std::uint32_t>(dial));
      const auto size = static_cast<double>(reply.bytes.size());
      const auto place = static_cast<std::size_t>(random.uniform(2 * noise_count_) * size);
      // Never the byte that was there.
      const int flip = 1 + static_cast<int>(random.uniform(2 * noise_count_ + 1) * 126.0);
      reply.bytes[place] = static_cast<char>(reply.bytes[place] ^ flip);
      ++noise_count_;
    }
    if (panel_->take(dial, Fault::kStrayLf)) reply.bytes += '\n';
  }
  if (!reply.bytes.empty()) send(std::move(reply.bytes), after);
}

void SerialLine::send(std::string bytes, Clock::duration after) {
  const Clock::duration each = wall(dialect_.line.character_s() / speed_);
  const Clock::time_point begin = std::max(Clock::now() + after, free_at_);
  free_at_ = begin + each * static_cast<std::int64_t>(bytes.size());
  out_.push_back({begin + each, each, std::move(bytes), 0});
}

void SerialLine::attend(Clock::time_point now) {
  if (comes_back_) {
    if (now < *comes_back_) return;
    comes_back_.reset();
    terminal_.emplace(link_);
  }
  for (const std::size_t dial : own_dials()) {
    if (panel_->take(dial, Fault::kUnsolicitedLine)) {
      if (std::string line = dialect_.key_pressed(dial, *panel_); !line.empty()) {
        send(std::move(line), Clock::duration::zero());
      }
    }
    if (panel_->take(dial, Fault::kPowerOnLine)) {
      if (std::string line = dialect_.power_on(dial); !line.empty()) {
        send(std::move(line), Clock::duration::zero());
      }
    }
    if (const auto order = panel_->take(dial, Fault::kHangUp)) {
      hang_up();
      comes_back_ = now + wall(order->amount.value_or(kHungUp_s));
      return;
    }
  }
  while (!out_.empty()) {
    Out& out = out_.front();
    std::size_t due = out.sent;
    while (due < out.bytes.size() &&
           out.first + out.each * static_cast<std::int64_t>(due) <= now + kTogether) {
      ++due;
    }
    if (due == out.sent) return;
    // Nobody reading and the terminal full: lost, as on a real line.
    [[maybe_unused]] const ssize_t n =
        ::write(descriptor(), out.bytes.data() + out.sent, due - out.sent);
    out.sent = due;
    if (out.sent < out.bytes.size()) return;
    out_.pop_front();
  }
}

std::optional<SerialLine::Clock::time_point> SerialLine::next_due() const {
  if (comes_back_) return comes_back_;
  if (out_.empty()) return std::nullopt;
  return out_.front().first + out_.front().each * static_cast<std::int64_t>(out_.front().sent);
}

}  // namespace sixdial::mock_devices
