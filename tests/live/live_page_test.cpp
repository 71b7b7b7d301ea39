// The live page: who is let in, and a whole session on the mock rig driven from it in Chromium.
#include "service/live/live_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "mock_devices/iso_time.h"
#include "mock_devices/mock_rig.h"
#include "session/rig_file.h"
#include "tests/live/browser_page.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::service {
namespace {

using testing::BrowserPage;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::RunningService;
using ::testing::StartsWith;

constexpr double kSpeed = 20.0;  // rig seconds a wall second
const std::string kToken = "0123456789abcdef0123456789abcdef";

/// The whole answer to a request in plain bytes.
std::string ask(std::uint16_t port, const std::string& request) {
  asio::io_context loop;
  asio::ip::tcp::socket socket(loop);
  socket.connect({asio::ip::address_v4::loopback(), port});
  asio::write(socket, asio::buffer(request));
  std::string reply;
  boost::system::error_code end;
  asio::read(socket, asio::dynamic_buffer(reply), end);
  return reply;
}

std::string get(
    std::uint16_t port, const std::string& path, const std::string& host,
    const std::string& more = "") {
  return ask(
      port, "GET " + path + " HTTP/1.1\r\nHost: " + host + "\r\n" + more +
                "Connection: close\r\n\r\n");
}

std::string upgrade_request(
    const std::string& path, const std::string& host, const std::string& origin) {
  return "GET " + path + " HTTP/1.1\r\nHost: " + host +
         "\r\nConnection: Upgrade, close\r\nUpgrade: websocket\r\n"
         "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
         (origin.empty() ? "" : "Origin: " + origin + "\r\n") + "\r\n";
}

std::string upgrade(
    std::uint16_t port, const std::string& path, const std::string& host,
    const std::string& origin) {
  return ask(port, upgrade_request(path, host, origin));
}

/// As the page itself asks; the answer's head only, as the connection then goes on.
std::string upgrade_head(std::uint16_t port, const std::string& path, const std::string& host) {
  asio::io_context loop;
  asio::ip::tcp::socket socket(loop);
  socket.connect({asio::ip::address_v4::loopback(), port});
  asio::write(socket, asio::buffer(upgrade_request(path, host, "http://" + host)));
  std::string head;
  asio::read_until(socket, asio::dynamic_buffer(head), "\r\n\r\n");
  return head;
}

/// True once the button can be pressed.
std::string can(const std::string& command) {
  return "document.querySelector('[data-do=" + command +
         "]').getAttribute('aria-disabled') === 'false'";
}
const std::string kCanStart = can("start");

class LivePageDoor : public ::testing::Test {
 protected:
  LivePageDoor()
      : page_({.socket_path = running_.socket_path(), .port = 0, .token = kToken}),
        host_("127.0.0.1:" + std::to_string(page_.port())),
        root_("/" + kToken + "/") {}
  RunningService running_;
  LivePage page_;
  const std::string host_, root_;
};

TEST_F(LivePageDoor, OpensWithTheTokenOnly) {
  EXPECT_EQ(page_.url(), "http://" + host_ + root_);
  for (const char* file : {"", "live.css", "live.js", "link.js", "drawing.js"}) {
    EXPECT_THAT(get(page_.port(), root_ + file, host_), StartsWith("HTTP/1.1 200"));
  }
  for (const std::string& path :
       {std::string("/"), std::string("/live.js"), "/" + std::string(32, '0') + "/",
        "/" + kToken.substr(1) + "/", "/" + kToken + "0/",
        "/x" + kToken.substr(1) + "/live.js"}) {
    const std::string reply = get(page_.port(), path, host_);
    EXPECT_THAT(reply, StartsWith("HTTP/1.1 403")) << path;
    EXPECT_THAT(reply, HasSubstr("Wrong token")) << path;
    EXPECT_THAT(reply, Not(HasSubstr(kToken)));
  }
  EXPECT_THAT(get(page_.port(), root_ + "nothing", host_), StartsWith("HTTP/1.1 404"));
}

TEST_F(LivePageDoor, RefusesANameThatWasBentToTheLoopback) {
  for (const std::string host :
       {"evil.example", "evil.example:80", "127.0.0.1", "127.0.0.1:1"}) {
    EXPECT_THAT(get(page_.port(), root_, host), HasSubstr("403")) << host;
  }
  const std::string other_name = "localhost:" + std::to_string(page_.port());
  EXPECT_THAT(get(page_.port(), root_, other_name), StartsWith("HTTP/1.1 200"));
}

TEST_F(LivePageDoor, RefusesPagesOfAnotherOrigin) {
  for (const std::string& origin :
       {std::string("http://evil.example"), "https://" + host_, std::string("null"),
        "http://" + host_ + ".evil.example", std::string()}) {
    EXPECT_THAT(upgrade(page_.port(), root_ + "socket", host_, origin), HasSubstr("403"))
        << origin;
  }
  EXPECT_THAT(
      get(page_.port(), root_, host_, "Origin: http://evil.example\r\n"), HasSubstr("403"));
  EXPECT_THAT(
      upgrade(page_.port(), "/wrong/socket", host_, "http://" + host_), HasSubstr("403"));
}

TEST_F(LivePageDoor, TellsTheBrowserToKeepTheTokenAndTheFrameToItself) {
  const std::string reply = get(page_.port(), root_, host_);
  EXPECT_THAT(reply, HasSubstr("Referrer-Policy: no-referrer"));
  EXPECT_THAT(reply, HasSubstr("frame-ancestors 'none'"));
  EXPECT_THAT(reply, HasSubstr("Cache-Control: no-store"));
  EXPECT_THAT(reply, Not(HasSubstr("unsafe-inline")));
}

TEST_F(LivePageDoor, OutlivesBrokenAndUnfinishedRequests) {
  EXPECT_THAT(ask(page_.port(), "\r\nnonsense\r\n\r\n"), Not(HasSubstr("200")));
  ask(page_.port(), "GET / HTTP/1.1\r\nX: " + std::string(20'000, 'x') + "\r\n\r\n");
  EXPECT_THAT(
      ask(page_.port(), "POST " + root_ + " HTTP/1.1\r\nHost: " + host_ +
                            "\r\nConnection: close\r\nContent-Length: 0\r\n\r\n"),
      HasSubstr("405"));
  EXPECT_THAT(get(page_.port(), root_, host_), StartsWith("HTTP/1.1 200"));
}

TEST_F(LivePageDoor, DataNeedTheTokenTheHostAndTheOrigin) {
  for (const std::string path : {"report/monday", "socket", "live.js"}) {
    EXPECT_THAT(get(page_.port(), "/" + path, host_), StartsWith("HTTP/1.1 403")) << path;
    EXPECT_THAT(
        get(page_.port(), root_ + path, "rebound.example:" + std::to_string(page_.port())),
        StartsWith("HTTP/1.1 403"))
        << path;
  }
  EXPECT_THAT(
      upgrade(page_.port(), "/socket", host_, "http://" + host_), StartsWith("HTTP/1.1 403"));
  const std::string good = upgrade_head(page_.port(), root_ + "socket", host_);
  EXPECT_THAT(good, StartsWith("HTTP/1.1 101"));
}

TEST_F(LivePageDoor, RefusesMoreVisitorsThanItTakesAndServesAgainWhenTheyHaveGone) {
  asio::io_context loop;
  std::vector<asio::ip::tcp::socket> crowd;
  constexpr std::size_t kMany = 40;  // above the page's limit of 32
  for (std::size_t i = 0; i < kMany; ++i) {
    crowd.emplace_back(loop).connect({asio::ip::address_v4::loopback(), page_.port()});
  }
  EXPECT_EQ(get(page_.port(), root_, host_), "");  // closed without a word: no thread is spent
  crowd.clear();
  EXPECT_TRUE(testing::eventually(
      [&] { return get(page_.port(), root_, host_).starts_with("HTTP/1.1 200"); }));
}

TEST_F(LivePageDoor, AFrameBeyondTheLimitEndsItsConnectionOnly) {
  asio::io_context loop;
  asio::ip::tcp::socket socket(loop);
  socket.connect({asio::ip::address_v4::loopback(), page_.port()});
  asio::write(
      socket, asio::buffer(upgrade_request(root_ + "socket", host_, "http://" + host_)));
  std::string head;
  asio::read_until(socket, asio::dynamic_buffer(head), "\r\n\r\n");
  ASSERT_THAT(head, StartsWith("HTTP/1.1 101"));
  // A masked text frame that says it has 2 MiB; the request limit is 1 MiB.
  const std::string frame{'\x81', '\xff', 0, 0, 0, 0, 0, 0x20, 0, 0, 'm', 'a', 's', 'k'};
  asio::write(socket, asio::buffer(frame));
  socket.shutdown(
      asio::ip::tcp::socket::shutdown_send);  // nothing else ends a wait for the rest
  std::string rest;
  boost::system::error_code end;
  asio::read(socket, asio::dynamic_buffer(rest), end);
  EXPECT_TRUE(end) << "the connection goes on";
  EXPECT_THAT(rest, HasSubstr("\x88"));  // a close frame
  EXPECT_THAT(get(page_.port(), root_, host_), StartsWith("HTTP/1.1 200"));
}

TEST_F(LivePageDoor, AReportThatCannotBeMadeSaysWhy) {
  const std::string reply = get(page_.port(), root_ + "report/none%20such", host_);
  EXPECT_THAT(reply, StartsWith("HTTP/1.1 409"));
  EXPECT_THAT(reply, HasSubstr("none such"));
  EXPECT_THAT(get(page_.port(), root_ + "report/%zz", host_), StartsWith("HTTP/1.1 400"));
}

TEST_F(LivePageDoor, ATakenPortIsSaid) {
  try {
    const LivePage second({.socket_path = running_.socket_path(), .port = page_.port()});
    FAIL() << "two pages on one port";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr(std::to_string(page_.port())));
  }
}

TEST(LivePageToken, IsNewEachTime) {
  const std::string one = new_live_token();
  EXPECT_EQ(one.size(), 32U);
  EXPECT_EQ(one.find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_NE(one, new_live_token());
}

TEST(LivePageBrowser, AWholeSessionIsDrivenFromThePage) {
  mock_devices::MockRigOptions options;
  options.world.rig = geometry::default_rig();
  options.world.robot.parameters = geometry::table_2_robot();
  options.clock_speed = kSpeed;
  mock_devices::MockRig mock(options);
  mock.start();
  ServiceOptions service_options;
  service_options.clock_speed = kSpeed;
  service_options.clock_start = session::from_iso8601(mock_devices::iso8601(mock.utc_ms()));
  RunningService running({}, service_options);
  auto page = std::make_unique<LivePage>(
      LivePageOptions{.socket_path = running.socket_path(), .port = 0, .token = kToken});
  const std::uint16_t port = page->port();

  // An empty store says what to do; a session made here is there at once.
  BrowserPage browser;
  browser.open(page->url());
  browser.until("document.body.innerText.includes('There is no session yet')");
  const std::string rig = Json(session::write_rig(mock.connected_rig("modbus-tcp"))).dump();
  browser.run(
      "(() => { const t = new DataTransfer(); t.items.add(new File([" + rig +
      "], 'rig.toml')); document.getElementById('new-rig').files = t.files;"
      "document.getElementById('new-name').value = 'tablet';"
      "document.getElementById('create').requestSubmit(); })()");
  browser.until("document.getElementById('session').value === 'tablet'");
  EXPECT_TRUE(browser.run("document.querySelector('[data-do=pause]').hidden"));
  browser.until(
      "document.querySelector('[data-do=calibrate]').title === "
      "'Not now: nothing is measured yet.'");
  EXPECT_EQ(
      browser.run("[...document.querySelectorAll('.dial')].map(d => d.dataset.state).join()"),
      "unread,unread,unread,unread,unread,unread");

  const auto go_on = [&] {  // a command may end the pause, or lead into the next
    browser.until(
        "(() => { const s = document.getElementById('state').textContent;"
        "if (s.includes('PAUSED')) document.querySelector('[data-do=resume]').click();"
        "return s.includes('▶ collecting') || s.includes('✓ collected'); })()");
  };

  // Start by a button: dials, pose, map and estimate fill.
  browser.run(
      "document.getElementById('g1').value = 24; document.getElementById('g2').value = 8");
  browser.click("start");
  browser.until("document.querySelectorAll('#map [data-mark=done]').length >= 3");
  browser.until("document.querySelectorAll('#map [data-mark=next]').length === 1");
  browser.until(
      "[...document.querySelectorAll('.dial .value')]"
      ".filter(v => /^-?\\d+\\.\\d{3} mm$/.test(v.textContent)).length >= 3");
  browser.until("/\\d\\.\\d{3}/.test(document.getElementById('pose').textContent)");
  browser.until("document.querySelectorAll('#estimate tbody tr').length === 10");
  EXPECT_EQ(browser.run("document.getElementById('bar').max"), 32);

  // A dial is unplugged: the page says which, and waits. Back again: a key goes on.
  mock.order_fault("C", {.fault = mock_devices::Fault::kSilent, .count = 0});
  browser.until("document.querySelector('[data-dial=C]').dataset.state === 'lost'");
  browser.until("document.getElementById('state').textContent.includes('PAUSED')");
  EXPECT_THAT(
      browser.run("document.getElementById('notice').textContent").get<std::string>(),
      HasSubstr("C"));
  mock.clear_faults();
  browser.until("document.querySelector('[data-dial=C]').dataset.state !== 'lost'");
  browser.keys("c");
  browser.until("document.getElementById('state').textContent.includes('collecting')");

  // Pause, retake and skip by keys: a new row for the same point, and one left out. What leaves
  // out or takes back is asked first; any key but y is a no.
  const auto key_that_asks = [&](const std::string& key) {
    browser.keys(key);
    browser.until("!document.getElementById('ask').hidden");
    browser.keys(key);
    browser.until("document.getElementById('ask').hidden");
    browser.keys(key);
    browser.until("!document.getElementById('ask').hidden");
    browser.keys("y");
    browser.until("document.getElementById('ask').hidden");
  };
  browser.keys("p");
  browser.until("document.getElementById('state').textContent.includes('PAUSED')");
  key_that_asks("r");
  browser.until("document.getElementById('events').textContent.includes('retaken')");
  go_on();
  browser.keys("p");
  browser.until("document.getElementById('state').textContent.includes('PAUSED')");
  key_that_asks("s");
  browser.until("document.querySelectorAll('#map [data-mark=left]').length === 1");
  go_on();

  // The way to the page breaks: large words, and what was missed is made up for.
  page.reset();
  browser.until("!document.getElementById('lost').hidden");
  EXPECT_THAT(
      browser.run("document.getElementById('lost').innerText").get<std::string>(),
      HasSubstr("Connection to the service lost"));
  EXPECT_TRUE(
      browser.run("document.getElementById('lost').getBoundingClientRect().height > 60"));
  page = std::make_unique<LivePage>(
      LivePageOptions{.socket_path = running.socket_path(), .port = port, .token = kToken});
  browser.until("document.getElementById('lost').hidden");
  browser.until("document.getElementById('state').textContent.includes('✓ collected')");
  // What was skipped is open again once the collection has ended; start measures it.
  browser.until("document.querySelectorAll('#map [data-mark=open]').length === 1");
  browser.until(kCanStart);
  browser.keys("g");
  browser.until("document.querySelectorAll('#map [data-mark=open]').length === 0");
  browser.until("document.getElementById('state').textContent.includes('✓ collected')");
  db::Store& reader = running.service().reader();
  const auto rows = reader.list_samples(reader.find_session("tablet"));
  const std::size_t live = reader.load_session(reader.find_session("tablet")).samples.size();
  EXPECT_EQ(live, 32U);
  EXPECT_EQ(rows.size(), live + 1);  // the retake is a row of its own
  EXPECT_EQ(
      browser.run("[...document.querySelectorAll('#events li')]"
                  ".filter(e => /(stored|retaken) G\\d point/.test(e.textContent)).length"),
      33);  // none missed, none twice

  // Undo opens the last point again; start measures it.
  browser.until(can("undo"));
  key_that_asks("u");
  browser.until("document.querySelectorAll('#map [data-mark=open]').length === 1");
  browser.until(kCanStart);
  browser.keys("g");
  browser.until("document.querySelectorAll('#map [data-mark=done]').length === 32");
  browser.until("document.getElementById('state').textContent.includes('✓ collected')");

  // Calibrate and watch the swarms.
  browser.until(can("calibrate"));
  browser.keys("k");
  browser.until("document.querySelectorAll('#convergence .line1').length > 0");
  browser.until("/calibration done/.test(document.getElementById('job-words').textContent)");
  browser.until("document.querySelectorAll('#convergence .line2').length > 0");
  browser.until(
      "/G2: .* mm before, .* mm after/.test(document.getElementById('result').textContent)");
  // Diagnose: to its end. The report comes in a tab of its own.
  browser.until(can("diagnose"));
  browser.keys("d");
  browser.until("/diagnosis: /.test(document.getElementById('job-words').textContent)");
  browser.until("/diagnosis done/.test(document.getElementById('job-words').textContent)");
  browser.until(can("report"));
  browser.keys("o");
  const Json complaints = browser.complaints();
  for (const Json& each : complaints) {  // but for the time without a link
    EXPECT_THAT(each.dump(), ::testing::AnyOf(HasSubstr("socket"), HasSubstr("ERR_CONNECTION")))
        << each;
  }
  browser.go_to_tab(kToken + "/report/tablet");
  browser.until("document.readyState === 'complete' && !!document.querySelector('h1')");
  browser.until("document.body.innerText.includes('tablet')");
  EXPECT_TRUE(browser.run("document.querySelectorAll('figure svg').length > 3"));
  EXPECT_THAT(
      browser.run("document.body.innerText").get<std::string>(),
      HasSubstr("What the simulation gets wrong"));
  EXPECT_TRUE(browser.complaints_here().empty()) << browser.complaints_here();
}

}  // namespace
}  // namespace sixdial::service
