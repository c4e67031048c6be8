// The manual: the look that the console has.

document.documentElement.dataset.theme = localStorage.getItem("theme") ?? "day";
