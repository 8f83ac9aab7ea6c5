// The token → a session, kept in a cookie that scripts cannot read.
const form = document.getElementById("login");
form.addEventListener("submit", async (event) => {
  event.preventDefault();
  const said = document.getElementById("said");
  const answer = await fetch("/api/login", {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify({ token: document.getElementById("token").value.trim() }),
  });
  if (answer.ok) location.reload();
  else said.textContent = answer.status === 429 ? "Wait a second, then try again." : "Wrong token.";
});
