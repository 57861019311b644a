#include "app/output/sha256.h"

#include <gtest/gtest.h>

#include "renderer/core/error.h"
#include "renderer/io/atomic_file.h"
#include "tests/app/output/synthetic_run.h"

namespace pathfit::app::sha256_test {
namespace {

// The messages of FIPS 180-4's examples, and their digests as coreutils' sha256sum prints them.
TEST(Sha256, GivesTheKnownDigests) {
  EXPECT_EQ(Sha256Hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(Sha256Hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(Sha256Hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(Sha256Hex(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, HashesFilesAndNamesTheMissingOne) {
  const TemporaryFolder folder("sha256");
  const std::string bytes(200000, 'x');
  renderer::WriteFileAtomically(folder.path() / "file", bytes);
  EXPECT_EQ(Sha256OfFile(folder.path() / "file"), Sha256Hex(bytes));
  EXPECT_THROW(Sha256OfFile(folder.path() / "none"), renderer::IoError);
}

TEST(Base64, PadsEveryRemainder) {
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Base64("M"), "TQ==");
  EXPECT_EQ(Base64("Ma"), "TWE=");
  EXPECT_EQ(Base64("Man"), "TWFu");
  EXPECT_EQ(Base64("\xff\xfe\xfd"), "//79");
}

}  // namespace
}  // namespace pathfit::app::sha256_test
