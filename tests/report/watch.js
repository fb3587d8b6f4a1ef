// Runs before the page: what goes wrong in it is kept for the checks.
window.wrong = [];
window.addEventListener('error', event => window.wrong.push(`error: ${event.message}`));
window.addEventListener('unhandledrejection', event => window.wrong.push(`rejected: ${event.reason}`));
window.addEventListener('securitypolicyviolation', event => window.wrong.push(`refused: ${event.blockedURI}`));
for (const kind of ['error', 'warn']) console[kind] = (...said) => window.wrong.push(`console: ${said.join(' ')}`);
