#include "renderer/core/shared_vector.h"

#include <utility>

#include <gtest/gtest.h>

namespace pathfit::renderer::shared_vector_test {
namespace {

TEST(SharedVector, CopiesShareUntilOneChanges) {
  SharedVector<int> a = {1, 2, 3};
  const SharedVector<int> b = a;
  EXPECT_EQ(b.data(), std::as_const(a).data());
  EXPECT_EQ(std::as_const(a)[1], 2);
  EXPECT_EQ(b.data(), std::as_const(a).data()) << "reading copies nothing";
  a[1] = 7;
  EXPECT_NE(b.data(), std::as_const(a).data());
  EXPECT_EQ(a, (SharedVector<int>{1, 7, 3}));
  EXPECT_EQ(b, (SharedVector<int>{1, 2, 3}));
}

TEST(SharedVector, ChangesInPlaceWhenAlone) {
  SharedVector<int> a = {1, 2, 3};
  const int* before = a.data();
  { const SharedVector<int> copy = a; }
  for (int& item : a) item *= 2;
  EXPECT_EQ(a.data(), before);
  EXPECT_EQ(a.Items(), (std::vector<int>{2, 4, 6}));
}

TEST(SharedVector, EmptyOnesNeedNoMemory) {
  const SharedVector<int> none;
  EXPECT_TRUE(none.empty());
  EXPECT_EQ(none.begin(), none.end());
  EXPECT_EQ(none, SharedVector<int>(std::vector<int>()));
  SharedVector<int> some;
  some.push_back(4);
  some.emplace_back(5);
  EXPECT_EQ(some.size(), 2U);
  EXPECT_EQ(some.back(), 5);
  some.clear();
  EXPECT_TRUE(some.empty());
}

}  // namespace
}  // namespace pathfit::renderer::shared_vector_test
