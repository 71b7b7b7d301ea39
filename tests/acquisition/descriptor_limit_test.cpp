// libserialport and libmodbus abort the process on a descriptor above 1023: with so many open,
// a dial is a fault in words, and comes when there are fewer.
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/select.h>
#include <unistd.h>

#include "acquisition/dial_bank.h"
#include "session/reason.h"
#include "tests/acquisition/wire.h"

namespace sixdial::acquisition {
namespace {

using test::eventually;

/// Every descriptor below FD_SETSIZE, until it goes away.
class TakenDescriptors {
 public:
  TakenDescriptors() {
    rlimit limit{};
    ::getrlimit(RLIMIT_NOFILE, &limit);
    before_ = limit;
    limit.rlim_cur = std::min<rlim_t>(limit.rlim_max, 2 * FD_SETSIZE);
    ::setrlimit(RLIMIT_NOFILE, &limit);
    do {
      taken_.push_back(::open("/dev/null", O_RDONLY | O_CLOEXEC));
    } while (taken_.back() >= 0 && taken_.back() < FD_SETSIZE);
  }
  ~TakenDescriptors() { give_back(); }
  TakenDescriptors(const TakenDescriptors&) = delete;
  TakenDescriptors& operator=(const TakenDescriptors&) = delete;

  [[nodiscard]] int highest() const { return taken_.back(); }
  void give_back() {
    for (const int fd : taken_) ::close(fd);
    taken_.clear();
    ::setrlimit(RLIMIT_NOFILE, &before_);
  }

 private:
  rlimit before_{};
  std::vector<int> taken_;
};

TEST(DescriptorLimit, ADialBeyondItIsAFaultInWordsAndComesWhenThereIsRoom) {
  test::PtyDevice dial("\r", [](const std::string& request) {
    return request == "?\r" ? "+012.345\r" : "ERR1\r";
  });
  test::ModbusTable table;
  for (int i = 0; i < 2; ++i) test::put_int32(table.input, 2 * i, 4567);
  test::ModbusTcpServer box(table);
  geometry::Rig rig = geometry::default_rig();
  rig.dials.resize(2);
  rig.dials[0].connection = "serial:" + dial.path() + "?dialect=sylvac";
  rig.dials[1].connection = fmt::format("modbus-tcp://127.0.0.1:{}?unit=1&index=0", box.port());
  SystemClock clock;
  TakenDescriptors taken;
  ASSERT_GE(taken.highest(), FD_SETSIZE) << "the limit of open files is too low to try it";
  const auto bank = DialBank::open(rig, clock);
  ASSERT_TRUE(bank) << bank.error();
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_TRUE(eventually(
        [&] { return (*bank)->latest()[i].reason == session::reason::kDisconnected; }));
    EXPECT_THAT((*bank)->latest()[i].detail, ::testing::HasSubstr("too many files open"));
  }
  taken.give_back();
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_TRUE(eventually([&] { return (*bank)->latest()[i].value_mm.has_value(); }))
        << (*bank)->latest()[i].detail;
  }
}

}  // namespace
}  // namespace sixdial::acquisition
