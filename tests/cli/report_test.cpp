// SPDX-License-Identifier: Apache-2.0
// The watcher of interruption.h may say the last word while the work is still saying something. Built with
// ThreadSanitizer, which ends the test where one reads what the other writes.
#include "report.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sstream>
#include <string>
#include <thread>

namespace {

TEST(Report, ReadsWhatTheWorkIsStillWriting) {
  cli::Report report;
  testing::internal::CaptureStderr();
  std::thread watcher([&] {
    while (!report.json()) std::this_thread::yield();
    for (int i = 0; i < 100; ++i) {
      const std::string left = report.whatIsLeft();
      EXPECT_TRUE(left.empty() || left == "finished frames are kept" || left.starts_with("this file") ||
                  left.starts_with("these files"))
          << left;
      report.progress({{"phase", "phase"}}, 0.5);
    }
    report.end(70, "memory is running out");
  });
  report.start("fractal", true);
  for (int i = 0; i < 2000; ++i) {
    report.text() << "sentence " << i << " of the work" << '\n';
    report.count("number", i);
    report.making("file.vdb", true);
    report.wrote("file.vdb");
    report.noteKept("finished frames are kept");
    report.phaseEnded("phase", 1, 1, 0.5);
  }
  watcher.join();
  std::istringstream lines(testing::internal::GetCapturedStderr());
  nlohmann::json event;
  for (std::string line; std::getline(lines, line);) event = nlohmann::json::parse(line);
  EXPECT_EQ(event["event"], "end");
  EXPECT_EQ(event["error"], "memory is running out");
  // Whole sentences, in their order.
  for (std::size_t i = 0; i < event["messages"].size(); ++i)
    EXPECT_EQ(event["messages"][i], "sentence " + std::to_string(i) + " of the work");
}

}  // namespace
