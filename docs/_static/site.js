// The contents scroll to the entry of the page.
document.addEventListener("DOMContentLoaded", () => {
  const bar = document.querySelector(".sidebar-scroll");
  const entry = bar?.querySelector(".sidebar-tree .current-page");
  if (entry) bar.scrollTop += entry.getBoundingClientRect().top - bar.getBoundingClientRect().top - bar.clientHeight / 2;
});
